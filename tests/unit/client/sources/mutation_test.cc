// SPDX-License-Identifier: Apache-2.0
// Whatever befalls a log file, reading it ends with its entries or with an error that names the file: never otherwise.
#include <gtest/gtest.h>

#include <random>

#include "tests/support/status_assertions.h"
#include "tests/unit/client/sources/log_files.h"

namespace enfilade::sources {
namespace {

using sources::LogOptions;
using testing::Contents;
using ::testing::HasSubstr;
using testing::LogFiles;
using testing::ReadAll;
using testing::ReadLog;

class Mutation : public ::testing::TestWithParam<const char*> {
 protected:
  void ExpectOrderlyEnd(const std::string& text) {
    const auto path = files_.Write("mutated.log", text);
    const ReadLog log = ReadAll(path);
    if (!log.status.ok()) {
      ASSERT_EQ(log.status.code(), absl::StatusCode::kInvalidArgument) << log.status;
      ASSERT_THAT(testing::MessageOf(log.status), HasSubstr(path.string()));
    }
    for (const sources::LogEntry& entry : log.entries) ASSERT_OK(sensor::Validate(entry.payload));
    LogOptions skip;
    skip.skip_bad_lines = true;
    const ReadLog rest = ReadAll(path, skip);
    if (rest.status.ok()) {
      ASSERT_GE(rest.entries.size(), log.entries.size());
    }
  }

  LogFiles files_;
};

TEST_P(Mutation, CutOffAnywhere) {
  const std::string whole = Contents(testing::ProjectData(GetParam()));
  for (std::size_t size = 0; size < whole.size(); size += 1 + whole.size() / 120)
    ExpectOrderlyEnd(whole.substr(0, size));
}

TEST_P(Mutation, BytesChangedAtRandom) {
  const std::string whole = Contents(testing::ProjectData(GetParam()));
  constexpr std::string_view kSpiteful = "0123456789.-+eEnaif \t\n\r{}[]\",:#\x80\xff";
  std::mt19937 random(3);
  for (int round = 0; round < 120; ++round) {
    std::string mutated = whole;
    for (std::uint32_t i = 0; i <= random() % 4; ++i) {
      const std::size_t at = random() % mutated.size();
      const char c = random() % 8 == 0 ? static_cast<char>(random()) : kSpiteful[random() % kSpiteful.size()];
      if (random() % 3 == 0) {
        mutated.erase(at, 1 + random() % 5);
      } else {
        mutated[at] = c;
      }
      if (mutated.empty()) break;
    }
    ExpectOrderlyEnd(mutated);
  }
}

INSTANTIATE_TEST_SUITE_P(All, Mutation,
                         ::testing::Values("logs/small.clf", "logs/small.jsonl", "logs/wean_hall.log",
                                           "logs/mines_paris.dat"),
                         [](const auto& param) {
                           const std::string name = std::filesystem::path(param.param).filename();
                           return name.substr(0, name.find('.')) + name.substr(name.find('.') + 1);
                         });

}  // namespace
}  // namespace enfilade::sources
