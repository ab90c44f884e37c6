// SPDX-License-Identifier: Apache-2.0
#include "core/sensor/record_codec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

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
  DoorReport out_of_lift;
  out_of_lift.level_time = 3;
  DoorReport ahead;
  ahead.T_odom_gap = Pose2{2.0, 0.1, -0.2};
  DoorReport of_all = out_of_lift;
  of_all.T_odom_gap = ahead.T_odom_gap;
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
          {7, DoorReport()},
          {8, out_of_lift},
          {9, ahead},
          {10, of_all}};
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

// Whatever bytes arrive, the decoder ends with an error or with a record that encodes and decodes to itself.
TEST(RecordCodec, MutatedBytesGiveAnErrorOrAStableRecord) {
  std::mt19937_64 random(11);
  int errors = 0;
  for (const Record& record : OneOfEachKind()) {
    const std::string bytes = EncodePayload(record);
    for (int trial = 0; trial < 400; ++trial) {
      std::string mutated = bytes;
      for (std::uint64_t flips = 1 + random() % 3; flips > 0; --flips) {
        mutated[random() % mutated.size()] = static_cast<char>(random());
      }
      if (trial % 5 == 0) mutated.insert(random() % mutated.size(), 1 + random() % 9, static_cast<char>(random()));
      const auto decoded = DecodePayload(record.sequence, KindOf(record), mutated);
      if (!decoded.ok()) {
        EXPECT_CODE(decoded, absl::StatusCode::kDataLoss);
        ++errors;
        continue;
      }
      EXPECT_EQ(KindOf(*decoded), KindOf(record));
      const std::string again = EncodePayload(*decoded);
      ASSERT_OK_AND_ASSIGN(const Record twice, DecodePayload(record.sequence, KindOf(record), again));
      EXPECT_EQ(EncodePayload(twice), again);
    }
  }
  EXPECT_GT(errors, 500) << "most lengths and versions are wrong";
}

TEST(RecordCodec, RandomScansRoundTrip) {
  std::mt19937_64 random(12);
  for (int trial = 0; trial < 50; ++trial) {
    LaserScan scan;
    scan.time = static_cast<TimeNs>(random() >> 1);
    scan.angle_min = static_cast<double>(random() % 1000) / 7.0;
    scan.angle_increment = -1.0 / static_cast<double>(1 + random() % 1000);
    scan.range_max = static_cast<float>(random() % 100);
    for (std::uint64_t beams = random() % 300; beams > 0; --beams) {
      scan.ranges.push_back(static_cast<float>(random() % 100'000) * 1e-3F);
    }
    const std::string bytes = EncodePayload({1, scan});
    std::string appended = "before";
    AppendPayload({1, scan}, appended);
    EXPECT_EQ(appended, "before" + bytes);
    ASSERT_OK_AND_ASSIGN(const Record decoded, DecodePayload(1, RecordKind::kLaserScan, bytes));
    EXPECT_EQ(std::get<LaserScan>(decoded.payload), scan);
  }
}

TEST(RecordCodec, NamesAnUnknownVersion) {
  std::string bytes = EncodePayload({1, Odometry()});
  bytes[0] = 9;
  EXPECT_STATUS(DecodePayload(41, RecordKind::kOdometry, bytes), absl::StatusCode::kDataLoss,
                ::testing::AllOf(::testing::HasSubstr("record 41"), ::testing::HasSubstr("version 9")));
}

}  // namespace
}  // namespace enfilade::sensor
