// SPDX-License-Identifier: Apache-2.0
#include "core/slam/matching/wall_faces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/slam/matching/local_matching.h"
#include "core/slam/submaps/robot_rays.h"
#include "tests/unit/core/slam/synthetic_drive.h"

namespace enfilade::slam {
namespace {

using testing::Wall;

constexpr double kMatched = 0.1;  // m

// A wall 0.2 m thick along y between two rooms that end at 3 m.
std::vector<Wall> WallBetweenRooms() {
  return {{{-0.1, -3.0}, {-0.1, 3.0}}, {{0.1, -3.0}, {0.1, 3.0}},   {{-3.0, -3.0}, {3.0, -3.0}},
          {{-3.0, 3.0}, {3.0, 3.0}},   {{-3.0, -3.0}, {-3.0, 3.0}}, {{3.0, -3.0}, {3.0, 3.0}}};
}

std::vector<Eigen::Vector2d> FacesSeen(const std::vector<Pose2>& seen_from, const Pose2& T_submap_robot,
                                       const std::vector<Eigen::Vector2d>& points) {
  const testing::SyntheticScanner scanner{.beams = 720, .field_of_view = 2.0 * M_PI};
  SubmapGrid grid(0.05, {});
  for (const Pose2& pose : seen_from) {
    const auto scan = testing::Scan(WallBetweenRooms(), pose, scanner, 0, 3);
    EXPECT_TRUE(grid.Insert(pose, RobotRays(scan, {.max_range = 30.0, .no_return_range = 0.0})).ok());
  }
  LocalFields fields(0.05, {});
  fields.Rebuild(grid);
  return OnFacesSeen(grid, fields.field, points, T_submap_robot, kMatched);
}

const Pose2 kLeft{-1.5, 0.0, 0.0};
const Pose2 kRight{1.5, 0.0, 0.0};
const std::vector<Eigen::Vector2d> kAhead{{1.4, 0.0}, {1.4, 0.5}, {1.4, -0.5}};

TEST(OnFacesSeen, KeepsWhatTheGridShowsFromTheSameSide) { EXPECT_EQ(FacesSeen({kLeft}, kLeft, kAhead).size(), 3U); }

TEST(OnFacesSeen, LeavesOutAWallThatTheGridShowsFromTheOtherSide) {
  // 0.2 m farther, the face that the robot sees lies where the grid has the other one.
  EXPECT_TRUE(FacesSeen({kRight}, Pose2{-1.3, 0.0, 0.0}, kAhead).empty());
}

TEST(OnFacesSeen, KeepsAWallThatTheGridShowsFromBothSides) {
  EXPECT_EQ(FacesSeen({kLeft, kRight}, kLeft, kAhead).size(), 3U);
}

TEST(OnFacesSeen, KeepsWhatIsOnNoWallOfTheGrid) {
  EXPECT_EQ(FacesSeen({kRight}, Pose2{-2.0, 0.0, 0.0}, kAhead).size(), 3U);
}

}  // namespace
}  // namespace enfilade::slam
