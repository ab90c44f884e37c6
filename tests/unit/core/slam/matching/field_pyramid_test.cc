// SPDX-License-Identifier: Apache-2.0
#include "core/slam/matching/field_pyramid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/slam/matching/correlative_matcher.h"
#include "core/slam/matching/scan_points.h"
#include "core/slam/submaps/robot_rays.h"
#include "tests/support/pose_matchers.h"
#include "tests/unit/core/slam/synthetic_drive.h"

namespace enfilade::slam {
namespace {

using ::testing::HasSubstr;
using testing::PoseNear;

// A room with niches, and what is seen from somewhere in it.
class FieldPyramidTest : public ::testing::Test {
 protected:
  std::vector<Eigen::Vector2d> PointsFrom(const Pose2& T_world_robot) const {
    return RobotRays(Seen(T_world_robot), {.max_range = 30.0, .no_return_range = 0.0}).hits;
  }

  sensor::LaserScan Seen(const Pose2& T_world_robot) const {
    return testing::Scan(walls_, T_world_robot, {.beams = 360, .field_of_view = 2.0 * M_PI}, 0, 7);
  }

  SubmapGrid Grid() const {
    SubmapGrid grid(0.05, {});
    for (const Pose2& pose : {Pose2{4.0, 3.0, 0.0}, Pose2{8.0, 4.0, 1.0}, Pose2{6.0, 5.0, -2.0}}) {
      EXPECT_TRUE(grid.Insert(pose, RobotRays(Seen(pose), {.max_range = 30.0, .no_return_range = 0.0})).ok());
    }
    return grid;
  }

  const std::vector<testing::Wall> walls_ = testing::WallsFromText({"############",  //
                                                                    "#   #      #",  //
                                                                    "#         ##",  //
                                                                    "#          #",  //
                                                                    "##         #",  //
                                                                    "#     #    #",  //
                                                                    "############"},
                                                                   1.0);
  const Pose2 truth_{7.0, 3.5, 0.7};
  const PyramidOptions options_;
  const FieldPyramid pyramid_{Grid(), options_};
};

TEST_F(FieldPyramidTest, HalvesTheCellFromLevelToLevelDownToTheSubmapsOwn) {
  ASSERT_EQ(pyramid_.levels.size(), 4U);
  const double expected[] = {0.4, 0.2, 0.1, 0.05};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_DOUBLE_EQ(pyramid_.levels[i].resolution(), expected[i]);
  EXPECT_DOUBLE_EQ(pyramid_.table.resolution(), options_.search_cell);
}

// From a metre away the finest field alone pulls nowhere right; the coarse ones lead there.
TEST_F(FieldPyramidTest, LeadsToThePoseFromAfar) {
  const Pose2 guess = truth_ * Pose2{0.9, -0.7, 0.3};
  const PyramidMatch match = MatchToPyramid(pyramid_, PointsFrom(truth_), guess, options_, {});
  EXPECT_TRUE(match.inliers_suffice) << match.reason;
  EXPECT_THAT(match.match.T_submap_robot, PoseNear(truth_, 0.02, 0.005));
  EXPECT_GT(match.match.matched_share, 0.9);

  PyramidOptions finest_only;
  finest_only.levels = 1;
  const FieldPyramid finest(Grid(), finest_only);
  const PyramidMatch alone = MatchToPyramid(finest, PointsFrom(truth_), guess, finest_only, {});
  EXPECT_GT(Between(truth_, alone.match.T_submap_robot).translation().norm(), 0.05);
}

TEST_F(FieldPyramidTest, EndsAtTheCoarsestLevelWhereTheScanDoesNotBelong) {
  std::vector<Eigen::Vector2d> elsewhere;  // a wall aslant through where the submap knows free space
  for (int i = 0; i < 60; ++i) elsewhere.emplace_back(-3.0 + 0.1 * i, 0.5 * (-3.0 + 0.1 * i));
  const PyramidMatch match = MatchToPyramid(pyramid_, elsewhere, truth_, options_, {});
  EXPECT_FALSE(match.inliers_suffice);
  EXPECT_THAT(match.reason, HasSubstr("below 0.60 at 0.4 m"));
}

TEST_F(FieldPyramidTest, AsksForMoreAtTheLevelWhereTheDemandIsHigher) {
  std::vector<Eigen::Vector2d> points = PointsFrom(truth_);
  // A third of the hits are moved half a cell of the coarsest level off their walls: inliers there, not below.
  for (std::size_t i = 0; i < points.size(); i += 3) points[i] *= 1.0 - 0.25 / points[i].norm();
  PyramidOptions strict = options_;
  strict.min_inliers = 0.9;
  const PyramidMatch match = MatchToPyramid(pyramid_, points, truth_, strict, {});
  EXPECT_FALSE(match.inliers_suffice);
  EXPECT_THAT(match.reason, ::testing::Not(HasSubstr("at 0.4 m")));
  EXPECT_TRUE(MatchToPyramid(pyramid_, points, truth_, options_, {}).inliers_suffice);
}

// The table that poses are searched in is of the same walls.
TEST_F(FieldPyramidTest, SearchesItsTable) {
  SearchWindow window;
  window.centre = truth_ * Pose2{1.5, -1.0, 0.4};
  window.half_width = 3.0;
  window.half_angle = M_PI;
  const SearchResult found = SearchPose(pyramid_.table, Subsampled(PointsFrom(truth_), 100), window);
  EXPECT_THAT(found.pose, PoseNear(truth_, 0.15, 0.05));
  EXPECT_GT(found.score, 0.6);
}

}  // namespace
}  // namespace enfilade::slam
