// SPDX-License-Identifier: Apache-2.0
#include "client/cli/output.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace enfilade::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(ProgressLine, ShowsShareRateAndTimeLeft) {
  const std::string line = ToLine({"sending", 0, 500, 2000, "", 10.0, ""});
  EXPECT_EQ(line, "sending  [=====>                  ]  25 %  500/2000  50/s  30.0 s left");
}

TEST(ProgressLine, CountsOnlyThisRunInItsRate) {
  EXPECT_THAT(ToLine({"sending", 900, 1000, 2000, "records", 10.0, ""}), HasSubstr("1000/2000 records  10/s"));
}

TEST(ProgressLine, WithoutATotalShowsTheCount) {
  EXPECT_EQ(ToLine({"reading", 0, 3 << 20, 0, "B", 2.0, "note"}), "reading  3.0 MiB  1.5 MiB/s  note");
}

TEST(ProgressLine, SaysNothingOfARateBeforeThereIsOne) {
  EXPECT_THAT(ToLine({"sending", 0, 0, 2000, "", 5.0, ""}), Not(HasSubstr("/s")));
  EXPECT_THAT(ToLine({"sending", 0, 3000, 2000, "", 5.0, ""}), HasSubstr("100 %"));
}

TEST(PrintTable, AlignsColumnsByCharacters) {
  std::ostringstream out;
  PrintTable(out, {"MAP", "CELLS", "NAME"}, {{"hall", "12", "Hall"}, {"caf\xc3\xa9", "3456789", "x"}});
  EXPECT_EQ(out.str(), "MAP   CELLS    NAME\nhall  12       Hall\ncaf\xc3\xa9  3456789  x\n");
}

TEST(PrintJson, ReplacesInvalidText) {
  std::ostringstream out;
  PrintJson(out, {{"name", "a\xff"}});
  EXPECT_EQ(out.str(), "{\n  \"name\": \"a\xEF\xBF\xBD\"\n}\n");
}

TEST(Format, RoundsToWhatPeopleRead) {
  EXPECT_EQ(FormatBytes(1023), "1023 B");
  EXPECT_EQ(FormatBytes(1536), "1.5 KiB");
  EXPECT_EQ(FormatBytes((1 << 20) - 1), "1.0 MiB");
  EXPECT_EQ(FormatBytes(64 << 20), "64.0 MiB");
  EXPECT_EQ(FormatSeconds(0.421), "0.42 s");
  EXPECT_EQ(FormatSeconds(59.99), "1:00");
  EXPECT_EQ(FormatSeconds(3723), "1:02:03");
}

}  // namespace
}  // namespace enfilade::cli
