// SPDX-License-Identifier: Apache-2.0
#include "core/grid/files/pgm_codec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/support/status_assertions.h"

namespace enfilade::grid {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string Encode(const PgmImage& image) {
  return EncodePgm({.width = image.width,
                    .height = image.height,
                    .max_value = image.max_value,
                    .header = image.header,
                    .trailer = image.trailer},
                   image.pixels);
}

TEST(PgmCodec, ReadsRowsFromTheBottom) {
  ASSERT_OK_AND_ASSIGN(const PgmImage image, DecodePgm("P5\n2 3\n255\nabcdef"));
  EXPECT_EQ(image.width, 2);
  EXPECT_EQ(image.height, 3);
  EXPECT_THAT(image.pixels, ElementsAre('e', 'f', 'c', 'd', 'a', 'b'));
}

class Spelling : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(PgmCodec, Spelling,
                         ::testing::Values("P5\n2 2\n255\nabcd",                                        //
                                           "P5\n# CREATOR: map_saver.cpp 0.050 m/pix\n2 2\n255\nabcd",  //
                                           "P5 2\t2\r255 abcd",                                         //
                                           "P5#one\n#two\n 2#three\n2 # four\n255\nabcd",               //
                                           "P5\n2 2\n255#five\nabcd",                                   //
                                           "P5\n002 2\n255\n\n\r #",  // pixels of white space
                                           "P5\n2 2\n255\nabcd\n",    //
                                           "P5\n2 2\n7\n\1\2\7\3",    //
                                           "P5\n2 2\n255\nabcdP5\n1 1\n255\nz"));

TEST_P(Spelling, IsRestoredByteForByte) {
  ASSERT_OK_AND_ASSIGN(const PgmImage image, DecodePgm(GetParam()));
  EXPECT_EQ(image.width, 2);
  EXPECT_EQ(image.height, 2);
  EXPECT_EQ(Encode(image), GetParam());
}

TEST(PgmCodec, ReadsPlainPixels) {
  ASSERT_OK_AND_ASSIGN(const PgmImage image, DecodePgm("P2 # by hand\n3 2\n100\n1 2 3 # a row\n\n40\t100 0"));
  EXPECT_EQ(image.max_value, 100);
  EXPECT_THAT(image.pixels, ElementsAre(40, 100, 0, 1, 2, 3));
  EXPECT_EQ(Encode(image), std::string("P5\n3 2\n100\n\1\2\3\x28\x64\0", 17));
}

TEST(PgmCodec, WritesAPlainHeaderWhereTheOldOneDoesNotFit) {
  ASSERT_OK_AND_ASSIGN(PgmImage image, DecodePgm("P5\n#x\n2 2\n255\nabcd\n"));
  image.width = 4;
  image.height = 1;
  EXPECT_EQ(Encode(image), "P5\n4 1\n255\ncdab");
  image.max_value = 254;
  EXPECT_EQ(Encode(image), "P5\n4 1\n254\ncdab");
}

struct BadPgm {
  std::string bytes;
  std::string message;
};

void PrintTo(const BadPgm& bad, std::ostream* os) { *os << bad.message; }

class BadPgmFile : public ::testing::TestWithParam<BadPgm> {};
INSTANTIATE_TEST_SUITE_P(
    PgmCodec, BadPgmFile,
    ::testing::Values(BadPgm{"", "not a PGM"}, BadPgm{"GIF89a", "not a PGM"}, BadPgm{"P5x2 2\n255\nabcd", "not a PGM"},
                      BadPgm{"P6\n1 1\n255\nabc", "P6 file"}, BadPgm{"P5\n", "ends before its width"},
                      BadPgm{"P5\n2", "ends before its height"}, BadPgm{"P5\n2 2\n", "ends before its largest grey"},
                      BadPgm{"P5\n2 2\n# comment without end", "ends before its largest grey"},
                      BadPgm{"P5\n2 2\n255", "ends after its header"}, BadPgm{"P5\n2 2\n255abcd", "no white space"},
                      BadPgm{"P5\n-2 2\n255\nabcd", "width is not a number"},
                      BadPgm{"P5\n2 2.5\n255\nabcd", "largest grey is not a number"},
                      BadPgm{"P5\n0 2\n255\n", "0 x 2 pixels"}, BadPgm{"P5\n2 0\n255\n", "2 x 0 pixels"},
                      BadPgm{"P5\n2 2\n0\nabcd", "largest grey is 0"}, BadPgm{"P5\n2 2\n65535\nabcdefgh", "16 bits"},
                      BadPgm{"P5\n2 2\n65536\nabcdefgh", "65536"}, BadPgm{"P5\n2 2\n255\nabc", "truncated"},
                      BadPgm{"P5\n2 2\n255\n", "truncated"}, BadPgm{"P5\n100000 100000\n255\nabc", "more than"},
                      BadPgm{"P5\n9999999999 9999999999\n255\nabc", "more than"},
                      BadPgm{"P5\n99999999999 1\n255\nabc", "10 digits"},
                      BadPgm{"P5\n10000 10000\n255\nabc", "truncated"},
                      BadPgm{"P5\n2 2\n7\n\1\2\10\3", "column 0, row 1"}, BadPgm{"P2\n2 2\n255\n1 2 3", "truncated"},
                      BadPgm{"P2\n2 2\n255\n11 22 33 ", "next pixel"}, BadPgm{"P2\n2 2\n255\n1 2 3 x", "next pixel"},
                      BadPgm{"P2\n2 2\n255\n1 2 3 -4", "next pixel"}, BadPgm{"P2\n2 2\n9\n1 2 3 10", "column 1, row 1"},
                      BadPgm{"P2\n2 2\n255\n1 2 3 256", "column 1, row 1"},
                      BadPgm{"P5\n#" + std::string(70'000, 'x') + "\n1 1\n255\na", "header"},
                      BadPgm{"P5\n1 1\n255\na" + std::string(70'000, 'x'), "70000 bytes follow"}));

TEST_P(BadPgmFile, IsRefusedWithTheReason) {
  EXPECT_STATUS(DecodePgm(GetParam().bytes), absl::StatusCode::kInvalidArgument, HasSubstr(GetParam().message));
}

TEST(PgmCodec, RefusesEveryTruncation) {
  const std::string whole = "P5\n# comment\n3 2\n255\nabcdef";
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(DecodePgm(std::string_view(whole).substr(0, size)).ok()) << size;
  }
}

}  // namespace
}  // namespace enfilade::grid
