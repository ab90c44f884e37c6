// SPDX-License-Identifier: Apache-2.0
#include "core/prior/slam/map_with_plan.h"

#include <gmock/gmock.h>

#include <cmath>
#include <complex>
#include <cstdint>

#include "core/prior/slam/plan_tracking.h"
#include "tests/support/plans/drawn_building.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/slam/synthetic_drive.h"

namespace enfilade::prior {
namespace {

// m: the sheet's y points down.
Eigen::Vector2d InWorld(const Eigen::Vector2d& sheet) { return 0.05 * Eigen::Vector2d(sheet.x(), -sheet.y()); }

// Along the corridor, into a room at its far end, into one on the way back, and into the first one.
const std::vector<Pose2> kDrive = testing::Drive({{1.5, -11.25},
                                                  {30.5, -11.25},
                                                  {30.5, -5.0},
                                                  {30.5, -11.25},
                                                  {22.5, -11.25},
                                                  {22.5, -6.5},
                                                  {22.5, -11.25},
                                                  {2.5, -11.25},
                                                  {2.5, -4.0}},
                                                 0.8);

// A scanner that sees a few metres far, and a robot whose wheels slip.
std::vector<sensor::PairedScan> Record(const PlanGraph& building, std::uint64_t seed) {
  std::vector<testing::Wall> walls;
  for (const PlanWall& wall : building.walls) {
    walls.push_back({InWorld(building.corners[static_cast<std::size_t>(wall.from)].point),
                     InWorld(building.corners[static_cast<std::size_t>(wall.to)].point)});
  }
  return testing::Record(walls, kDrive, {.range_max = 3.5}, {.translation_share = 0.1, .yaw_per_metre = 0.08}, seed);
}

// Two corners far apart, as a person would click them.
FitOptions Clicks() {
  FitOptions options;
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(0, 200), Eigen::Vector2d(680, 200)}) {
    options.pairs.push_back({corner, Inverse(kDrive.front()) * InWorld(corner) + Eigen::Vector2d(0.15, -0.1)});
  }
  return options;
}

// m, root of the mean of squares, after the turn and shift that fit best.
double ErrorOf(const slam::SlamMap& map) {
  std::vector<std::complex<double>> found, truth;
  const std::vector<slam::StampedPose> trajectory = slam::TrajectoryOf(map);
  EXPECT_EQ(trajectory.size(), kDrive.size());
  std::complex<double> mean, true_mean, turn;
  const auto count = static_cast<double>(trajectory.size());
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    found.emplace_back(trajectory[i].T_map_robot.x, trajectory[i].T_map_robot.y);
    truth.emplace_back(kDrive[i].x, kDrive[i].y);
    mean += found.back() / count;
    true_mean += truth.back() / count;
  }
  for (std::size_t i = 0; i < found.size(); ++i) turn += (truth[i] - true_mean) * std::conj(found[i] - mean);
  turn /= std::abs(turn);
  double squares = 0;
  for (std::size_t i = 0; i < found.size(); ++i) squares += std::norm((found[i] - mean) * turn + true_mean - truth[i]);
  return std::sqrt(squares / count);
}

TEST(MapWithPlanTest, ThePlanStraightensABentMap) {
  const PlanGraph plan = DrawnBuilding();
  for (const std::uint64_t seed : {1ULL, 2ULL, 3ULL}) {
    const std::vector<sensor::PairedScan> scans = Record(plan, seed);
    const double without = ErrorOf(MapLog(scans, {}).map);
    ASSERT_OK_AND_ASSIGN(const MapWithPlan result, MapLogWithPlan(plan, scans, Clicks(), {}));
    const double with = ErrorOf(result.mapped.map);
    EXPECT_TRUE(result.corrected) << seed << ": " << result.reason;
    EXPECT_GT(without, 0.3) << seed;
    EXPECT_LT(with, 0.6 * without) << seed << ": " << result.reason;
  }
}

TEST(MapWithPlanTest, AWrongPlanChangesNothing) {
  const std::vector<sensor::PairedScan> scans = Record(DrawnBuilding(), 1);
  const MappedLog without = MapLog(scans, {});
  PlanGraph wrong = DrawnBuilding();  // its rooms lie elsewhere
  for (PlanCorner& corner : wrong.corners) {
    corner.point = {corner.point.y() * 880 / 480, 480 - corner.point.x() * 480 / 880};
  }
  ASSERT_OK_AND_ASSIGN(const MapWithPlan result, MapLogWithPlan(wrong, scans, Clicks(), {}));
  EXPECT_FALSE(result.corrected) << result.reason;
  EXPECT_FALSE(result.reason.empty());
  EXPECT_EQ(result.mapped.map.nodes, without.map.nodes);
  EXPECT_EQ(result.mapped.map.trajectory, without.map.trajectory);
  EXPECT_EQ(result.mapped.grid.cells, without.grid.cells);
}

TEST(MapWithPlanTest, IsTheSameEachTime) {
  const PlanGraph plan = DrawnBuilding();
  const std::vector<sensor::PairedScan> scans = Record(plan, 4);
  ASSERT_OK_AND_ASSIGN(const MapWithPlan one, MapLogWithPlan(plan, scans, Clicks(), {}));
  ASSERT_OK_AND_ASSIGN(const MapWithPlan other, MapLogWithPlan(plan, scans, Clicks(), {}));
  EXPECT_EQ(one.reason, other.reason);
  EXPECT_EQ(one.mapped.map.nodes, other.mapped.map.nodes);
  EXPECT_EQ(one.mapped.grid.cells, other.mapped.grid.cells);
}

TEST(PlanTrackingTest, FollowsARobotWhoseOdometryIsFarOff) {
  const PlanGraph plan = DrawnBuilding();
  const PlanTransform T_map_sheet =
      Inverse(kDrive.front()) * PlanTransform{0.05 * Eigen::Matrix2d(Eigen::Vector2d(1, -1).asDiagonal()), {0, 0}};
  for (const std::uint64_t seed : {5ULL, 6ULL, 7ULL}) {
    const PlanTrack track = TrackInPlan(Transformed(FacesOf(plan), T_map_sheet), Record(plan, seed), {}, {});
    ASSERT_EQ(track.T_map_robot.size(), kDrive.size());
    double squares = 0;
    for (std::size_t i = 0; i < kDrive.size(); ++i) {
      const Pose2 error = Between(Between(kDrive.front(), kDrive[i]), track.T_map_robot[i]);
      squares += error.translation().squaredNorm();
    }
    EXPECT_LT(std::sqrt(squares / static_cast<double>(kDrive.size())), 0.25) << seed;
    EXPECT_GT(track.matched_share, 0.6);
  }
}

}  // namespace
}  // namespace enfilade::prior
