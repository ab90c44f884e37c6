// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/edit/map_edit.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/edit/random_edits.h"

namespace enfilade::edit {
namespace {

std::vector<Shape> Samples() {
  std::vector<Shape> samples;
  std::mt19937 random(3);
  const RandomShapes shapes{{-70'000, 5'000}};
  for (int i = 0; i < 400; ++i) samples.push_back(shapes.RandomShape(random));
  samples.push_back(Brush{{{kMaxCoordinate, -kMaxCoordinate}}, kMaxRadius});
  samples.push_back(Patch{{-2'097'152, 2'097'152, 4, 4}, {0xFFFFFFFF - 0xFFFFFFFFU, 16}});
  return samples;
}

TEST(ShapeCodec, RestoresEveryShape) {
  for (const Shape& shape : Samples()) {
    ASSERT_OK_AND_ASSIGN(const Shape decoded, DecodeShape(Encode(shape)));
    EXPECT_EQ(decoded, shape);
    EXPECT_EQ(Encode(decoded), Encode(shape));
  }
}

// Rows in databases keep these bytes for good.
TEST(ShapeCodec, WritesTheSameBytesInEveryRelease) {
  using std::string_literals::operator""s;
  EXPECT_EQ(Encode(Brush{{{1, -2}}, 258}), "\x01\x01\x02\x01\0\0\x01\0\0\0\x01\0\0\0\xFE\xFF\xFF\xFF"s);
  EXPECT_EQ(Encode(Line{{{3, 4}}}), "\x01\x02\x01\0\0\0\x03\0\0\0\x04\0\0\0"s);
  EXPECT_EQ(Encode(Patch{{-1, 2, 3, 4}, {5, 6}}),
            "\x01\x04\xFF\xFF\xFF\xFF\x02\0\0\0\x03\0\0\0\x04\0\0\0\x02\0\0\0\0\0\0\0\x05\0\0\0\x06\0\0\0"s);
  EXPECT_EQ(Encode(Polygon{{{{0, 0}, {1, 0}, {0, 1}}}}).substr(0, 10), "\x01\x03\x01\0\0\0\x03\0\0\0"s);
}

TEST(ShapeCodec, RefusesEveryPrefixAndEveryByteMore) {
  for (const Shape& shape : Samples()) {
    const std::string bytes = Encode(shape);
    for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 16) {
      EXPECT_CODE(DecodeShape(bytes.substr(0, size)), absl::StatusCode::kDataLoss) << size << " of " << bytes.size();
    }
    EXPECT_CODE(DecodeShape(bytes + '\0'), absl::StatusCode::kDataLoss);
  }
}

TEST(ShapeCodec, RefusesOtherVersionsAndKinds) {
  std::string bytes = Encode(Line{{{3, 4}}});
  bytes[0] = 2;
  EXPECT_STATUS(DecodeShape(bytes), absl::StatusCode::kFailedPrecondition, ::testing::HasSubstr("format 2"));
  bytes[0] = 0;
  EXPECT_CODE(DecodeShape(bytes), absl::StatusCode::kDataLoss);
  bytes[0] = 1;
  for (const char kind : {'\0', '\5', '\xFF'}) {
    bytes[1] = kind;
    EXPECT_CODE(DecodeShape(bytes), absl::StatusCode::kDataLoss);
  }
}

TEST(ShapeCodec, RefusesShapesThatAreNotValid) {
  EXPECT_STATUS(DecodeShape(Encode(Brush{{{0, 0}}, -1})), absl::StatusCode::kDataLoss,
                ::testing::HasSubstr("radius is -1"));
  EXPECT_CODE(DecodeShape(Encode(Line{})), absl::StatusCode::kDataLoss);
  EXPECT_CODE(DecodeShape(Encode(Patch{{0, 0, 2, 2}, {5}})), absl::StatusCode::kDataLoss);
  EXPECT_CODE(DecodeShape(Encode(Polygon{{{{0, 0}, {9, 9}, {9, 0}, {0, 9}}}})), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace enfilade::edit
