// SPDX-License-Identifier: Apache-2.0
#include "core/sensor/record_codec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "core/base/environment.h"
#include "tests/support/status_assertions.h"

namespace enfilade::sensor {
namespace {

std::vector<Record> OneOfEachKind() {
  LaserScan scan;
  scan.time = 976'052'858'304'357'000;
  scan.angle_min = -M_PI / 2.0;
  scan.angle_increment = M_PI / 180.0;
  scan.range_max = 81.83F;
  scan.T_robot_laser = {0.1, -0.2, 0.3};
  scan.ranges = {1.07F, -1.0F, std::numeric_limits<float>::infinity(), 81.83F};
  return {{1, scan},
          {2, Odometry{5, {1.0 / 3.0, -0.0, M_PI}}},
          {3, Image{7, Camera::kRear, ImageEncoding::kJpeg, {std::string(32, '\xff'), 12}}},
          {4, PointCloud{9, CloudEncoding::kXyz32, {std::string(32, '\0'), 64 << 20}}},
          {5, Withheld{"the server refused it"}},
          {6, DoorReport{9,
                         DoorReport::Kind::kPassage,
                         graph::LinkPointKind::kLift,
                         7,
                         {1.0, -2.0, 0.5},
                         0.9,
                         Environment::kOutdoor,
                         -1,
                         true,
                         "by hand"}},
          {7, DoorReport()}};
}

TEST(RecordCodec, RoundTripsEveryKindExactly) {
  for (const Record& record : OneOfEachKind()) {
    ASSERT_OK_AND_ASSIGN(const Record decoded, DecodePayload(record.sequence, KindOf(record), EncodePayload(record)));
    EXPECT_EQ(decoded, record) << record.sequence;
  }
}

TEST(RecordCodec, KeepsNanBitPatterns) {
  LaserScan scan;
  scan.ranges = {std::nanf("7")};
  ASSERT_OK_AND_ASSIGN(const Record decoded, DecodePayload(1, RecordKind::kLaserScan, EncodePayload({1, scan})));
  EXPECT_EQ(std::memcmp(std::get<LaserScan>(decoded.payload).ranges.data(), scan.ranges.data(), sizeof(float)), 0);
}

TEST(RecordCodec, RefusesEveryTruncationAndTrailingByte) {
  for (const Record& record : OneOfEachKind()) {
    const std::string bytes = EncodePayload(record);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      EXPECT_CODE(DecodePayload(1, KindOf(record), bytes.substr(0, size)), absl::StatusCode::kDataLoss);
    }
    EXPECT_CODE(DecodePayload(1, KindOf(record), bytes + "x"), absl::StatusCode::kDataLoss);
  }
  EXPECT_CODE(DecodePayload(1, static_cast<RecordKind>(77), EncodePayload(OneOfEachKind()[1])),
              absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace enfilade::sensor
