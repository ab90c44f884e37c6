// SPDX-License-Identifier: Apache-2.0
#include "core/slam/matching/correlative_matcher.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/slam/matching/likelihood_field.h"
#include "tests/support/pose_matchers.h"

namespace enfilade::slam {
namespace {

using testing::PoseNear;

// An L-shaped corner with a post.
std::vector<Eigen::Vector2d> Corner() {
  std::vector<Eigen::Vector2d> points;
  for (double s = 0.0; s < 4.0; s += 0.05) points.emplace_back(s, 0.0);
  for (double s = 0.0; s < 2.5; s += 0.05) points.emplace_back(0.0, s);
  points.emplace_back(1.5, 1.2);
  return points;
}

std::vector<Eigen::Vector2d> SeenFrom(const Pose2& T_world_robot) {
  std::vector<Eigen::Vector2d> points;
  for (const Eigen::Vector2d& p : Corner()) points.push_back(Inverse(T_world_robot) * p);
  return points;
}

SearchTable Table(int levels) {
  LikelihoodField field(0.05, 0.5);
  field.Add(Corner());
  SearchTable table(0.1, levels);
  table.Update(field, field.window());
  return table;
}

TEST(SearchTable, BoundsEveryLikelihoodInItsBlock) {
  const SearchTable table = Table(5);
  for (int level = 1; level < 5; ++level) {
    const int size = 1 << level;
    for (int row = -40; row < 80; row += 3) {
      for (int column = -40; column < 100; column += 3) {
        for (int dy = 0; dy < size; ++dy) {
          for (int dx = 0; dx < size; ++dx) {
            EXPECT_GE(table.At(level, column >> level, row >> level), table.At(0, column + dx, row + dy));
          }
        }
      }
    }
  }
}

TEST(SearchTable, UpdatedByPartsIsTheSameAsMadeAtOnce) {
  LikelihoodField field(0.05, 0.5);
  SearchTable parts(0.1, 5);
  for (const Eigen::Vector2d& p : Corner()) {
    field.Add({p});
    const grid::CellIndex cell{static_cast<int>(std::floor(p.x() / 0.05)), static_cast<int>(std::floor(p.y() / 0.05))};
    parts.Update(field, Intersection(Dilated({cell, 1, 1}, 10), field.window()));
  }
  const SearchTable whole = Table(5);
  for (int level = 0; level < 5; ++level) {
    for (int row = -40; row < 80; ++row) {
      for (int column = -40; column < 100; ++column) {
        ASSERT_EQ(parts.At(level, column, row), whole.At(level, column, row)) << level;
      }
    }
  }
}

TEST(SearchPose, FindsWhatTryingAllPosesFinds) {
  const SearchTable branching = Table(5);
  const SearchTable exhaustive = Table(1);  // one level: nothing is bounded, all is tried
  for (const Pose2& truth : {Pose2{1.3, 1.1, 0.2}, Pose2{2.0, 0.7, -0.35}}) {
    const auto points = SeenFrom(truth);
    const SearchWindow window{.centre = {1.6, 0.9, 0.0}, .half_width = 0.6, .half_angle = 0.5};
    const SearchResult found = SearchPose(branching, points, window);
    EXPECT_DOUBLE_EQ(found.score, SearchPose(exhaustive, points, window).score);
    EXPECT_THAT(found.pose, PoseNear(truth, 0.06, 0.02));
  }
}

TEST(SearchPose, LooksAllAround) {
  const Pose2 truth{1.3, 1.1, 2.9};
  const SearchResult found =
      SearchPose(Table(6), SeenFrom(truth), {.centre = {}, .half_width = 2.0, .half_angle = 4.0});
  EXPECT_THAT(found.pose, PoseNear(truth, 0.06, 0.02));
}

TEST(SearchPose, FindsNothingBelowTheMinimumAndNothingExcluded) {
  const Pose2 truth{1.3, 1.1, 0.1};
  SearchWindow window{.centre = truth, .half_width = 0.5, .half_angle = 0.3};
  window.min_score = 1.01;
  EXPECT_EQ(SearchPose(Table(5), SeenFrom(truth), window).score, 0.0);
  window.min_score = 0.0;
  const double best = SearchPose(Table(5), SeenFrom(truth), window).score;
  window.excluded = truth;
  window.excluded_distance = 0.3;
  window.excluded_angle = 0.2;
  const SearchResult other = SearchPose(Table(5), SeenFrom(truth), window);
  EXPECT_LT(other.score, best);
  const Pose2 off = Between(truth, other.pose);
  EXPECT_TRUE(off.translation().norm() >= 0.3 || std::abs(off.yaw) >= 0.2);
}

}  // namespace
}  // namespace enfilade::slam
