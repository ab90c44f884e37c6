// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/driver/wkb.h"

#include "tests/support/status_assertions.h"

namespace enfilade::storage::postgres {
namespace {

TEST(WkbTest, GivesBackTheCorners) {
  const std::vector<Eigen::Vector2d> corners = {{0.1, -1.0 / 3}, {500'000.123, 5.0}, {7.0, 8.0}};
  const std::string bytes = EncodePolygon(corners);
  EXPECT_EQ(bytes.size(), 1U + 4 + 4 + 4 + 4 * 16);
  ASSERT_OK_AND_ASSIGN(const auto decoded, DecodePolygon(bytes));
  EXPECT_EQ(decoded, corners);
  EXPECT_EQ(EncodePolygon({}), "");
}

TEST(WkbTest, RefusesEveryTruncation) {
  const std::string bytes = EncodePolygon({{0, 0}, {1, 0}, {1, 1}});
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_CODE(DecodePolygon(bytes.substr(0, size)), absl::StatusCode::kDataLoss) << size;
  }
}

TEST(WkbTest, RefusesOtherGeometries) {
  std::string line = EncodePolygon({{0, 0}, {1, 0}, {1, 1}});
  line[1] = 2;
  EXPECT_CODE(DecodePolygon(line), absl::StatusCode::kDataLoss);
  std::string big_endian = EncodePolygon({{0, 0}, {1, 0}, {1, 1}});
  big_endian[0] = 0;
  EXPECT_CODE(DecodePolygon(big_endian), absl::StatusCode::kDataLoss);
  std::string huge = EncodePolygon({{0, 0}, {1, 0}, {1, 1}});
  huge.replace(9, 4, "\xff\xff\xff\x7f");
  EXPECT_CODE(DecodePolygon(huge), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace enfilade::storage::postgres
