// SPDX-License-Identifier: Apache-2.0
// The recordings by others that the readers were made for; counts as their publishers' files hold them.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/client/sources/log_files.h"

namespace enfilade::sources {
namespace {

using testing::AllOf;
using testing::ReadAll;
using testing::ReadLog;

struct Expected {
  const char* name;
  const char* path;
  std::size_t scans;
  std::size_t odometry;
  std::size_t beams;
  float range_max;
  double increment_deg;
  bool synthetic_times;
  std::int64_t scans_back_in_time;
};

class Recording : public ::testing::TestWithParam<Expected> {};

TEST_P(Recording, ReadsWhole) {
  const Expected& expected = GetParam();
  ENFILADE_RECORDING_OR_SKIP(path, expected.path);
  const ReadLog log = ReadAll(path);
  ASSERT_OK(log.status);
  const auto scans = AllOf<sensor::LaserScan>(log);
  ASSERT_EQ(scans.size(), expected.scans);
  EXPECT_EQ(AllOf<sensor::Odometry>(log).size(), expected.odometry);
  EXPECT_EQ(log.facts.entries, static_cast<std::int64_t>(expected.scans + expected.odometry));
  EXPECT_EQ(log.facts.synthetic_times, expected.synthetic_times);
  EXPECT_EQ(log.counts.scans_back_in_time, expected.scans_back_in_time);
  for (const sensor::LaserScan& scan : scans) {
    ASSERT_EQ(scan.ranges.size(), expected.beams);
    ASSERT_EQ(scan.range_max, expected.range_max);
    ASSERT_NEAR(scan.angle_increment, expected.increment_deg * M_PI / 180.0, 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, Recording,
    ::testing::Values(
        Expected{"IntelRawOdometry", "laser/derived/intel_raw_odom.clf.gz", 2726, 2726, 180, 81.83F, 1.0, false, 0},
        Expected{"IntelCorrected", "laser/corrected_gfs/intel-corrected.log.gz", 910, 910 + 14541, 180, 81.83F, 1.0,
                 false, 4},
        Expected{"Freiburg101", "laser/corrected_gfs/freiburg-101-corrected.log.gz", 292, 292 + 4569, 360, 80.99F, 0.5,
                 false, 0},
        Expected{"Orebro", "laser/corrected_gfs/orebro-corrected.log.gz", 237, 237 + 255, 181, 32.759F, 1.0, true, 0},
        Expected{"Seattle", "laser/corrected_gfs/seattle-corrected.log.gz", 241, 241 + 19311, 361, 81.83F, 0.5, false,
                 0},
        Expected{"Flirtlib", "laser/flirtlib/intel-lab.log", 2672, 2672, 180, 50.0F, 1.0, false, 97},
        Expected{"WeanHall", "laser/wean_hall/robotdata1.log.gz", 713, 713 + 1505, 180, 81.83F, 1.0, false, 0},
        Expected{"MinesParis", "laser/mines_paris/exp1.dat", 756, 756, 682, 5.6F, 360.0 / 1024.0, false, 0}),
    [](const auto& param) { return param.param.name; });

TEST(Recording, IntelTimesAreExact) {
  ENFILADE_RECORDING_OR_SKIP(path, "laser/derived/intel_raw_odom.clf.gz");
  const auto scans = AllOf<sensor::LaserScan>(ReadAll(path));
  EXPECT_EQ(scans.at(2).time, 976'052'858'304'357'000);
  EXPECT_EQ(scans.back().time, 976'055'547'365'637'000);
}

TEST(Recording, FreiburgsLaserSitsWhereItsParametersSay) {
  ENFILADE_RECORDING_OR_SKIP(path, "laser/corrected_gfs/freiburg-101-corrected.log.gz");
  EXPECT_EQ(AllOf<sensor::LaserScan>(ReadAll(path)).at(0).T_robot_laser, (Pose2{-0.04, 0.0, 0.0}));
}

}  // namespace
}  // namespace enfilade::sources
