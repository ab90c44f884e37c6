// SPDX-License-Identifier: Apache-2.0
#include "core/slam/matching/correlative_matcher.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

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
            EXPECT_GE(table.ViewOf(level).At(column >> level, row >> level), table.ViewOf(0).At(column + dx, row + dy));
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
        ASSERT_EQ(parts.ViewOf(level).At(column, row), whole.ViewOf(level).At(column, row)) << level;
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

// Poses planted all over the window, also at its border; points on walls to a centimetre.
TEST(SearchPose, FindsThePlantedPose) {
  const SearchTable table = Table(6);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> offset(-0.95, 0.95);
  std::normal_distribution<double> noise(0.0, 0.01);
  for (int k = 0; k < 30; ++k) {
    const Pose2 centre{1.5, 1.0, 0.3};
    const Pose2 truth{centre.x + offset(random), centre.y + offset(random), centre.yaw + 0.6 * offset(random)};
    std::vector<Eigen::Vector2d> points = SeenFrom(truth);
    for (Eigen::Vector2d& p : points) p += Eigen::Vector2d(noise(random), noise(random));
    const SearchResult found = SearchPose(table, points, {.centre = centre, .half_width = 1.0, .half_angle = 0.6});
    EXPECT_THAT(found.pose, PoseNear(truth, 0.08, 0.03)) << k;
    EXPECT_GT(found.score, 0.8);
    EXPECT_LE(found.score, 1.0);
  }
}

// The score is that of the table at the pose: summed by hand.
TEST(SearchPose, ScoresTheMeanLikelihood) {
  const SearchTable table = Table(5);
  const auto points = SeenFrom({1.3, 1.1, 0.2});
  const SearchResult found = SearchPose(table, points, {.centre = {1.4, 1.0, 0.25}, .half_width = 0.4});
  double sum = 0.0;
  for (const Eigen::Vector2d& p : points) {
    const Eigen::Vector2d q = found.pose * p;
    sum += table.ViewOf(0).At(static_cast<int>(std::floor(q.x() / 0.05)), static_cast<int>(std::floor(q.y() / 0.05))) /
           255.0;
  }
  EXPECT_NEAR(found.score, sum / static_cast<double>(points.size()), 0.02) << "but for points at the border of a cell";
}

TEST(SearchPose, PrefersThePriorAmongEqualPlaces) {
  LikelihoodField field(0.05, 0.5);
  std::vector<Eigen::Vector2d> wall;
  for (double x = -6.0; x < 6.0; x += 0.02) wall.emplace_back(x, 0.0);
  field.Add(wall);
  SearchTable table(0.1, 5);
  table.Update(field, field.window());
  std::vector<Eigen::Vector2d> seen;  // a part of a wall that looks the same all along
  for (double x = -1.0; x < 1.0; x += 0.05) seen.emplace_back(x, 1.0);
  for (const double x : {-2.0, 0.0, 1.5}) {
    const SearchResult found = SearchPose(
        table, seen,
        {.centre = {x, -1.2, 0.0}, .half_width = 1.0, .half_angle = 0.1, .sigma_translation = 0.5, .sigma_yaw = 0.1});
    EXPECT_NEAR(found.pose.x, x, 0.051) << "along the wall only the prior decides";
    EXPECT_NEAR(found.pose.y, -1.0, 0.06);
  }
}

TEST(SearchPose, OfNoPointsIsTheCentre) {
  const Pose2 centre{1.0, 2.0, 0.5};
  const SearchResult found = SearchPose(Table(3), {}, {.centre = centre});
  EXPECT_EQ(found.pose, centre);
  EXPECT_EQ(found.score, 0.0);
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

TEST(SearchPose, FindsTheSameWhereItScoresMoreThanIsRelevant) {
  const Pose2 truth{1.3, 1.1, 0.1};
  SearchWindow window{
      .centre = truth, .half_width = 1.0, .half_angle = 0.3, .sigma_translation = 1.0, .sigma_yaw = 0.3};
  window.excluded = truth;
  window.excluded_distance = 0.3;
  window.excluded_angle = 0.2;
  const SearchResult other = SearchPose(Table(5), SeenFrom(truth), window);
  ASSERT_GT(other.score, 0.1);
  window.relevant_score = other.score - 0.001;
  const SearchResult same = SearchPose(Table(5), SeenFrom(truth), window);
  EXPECT_EQ(same.pose, other.pose);
  EXPECT_EQ(same.score, other.score);
  window.relevant_score = other.score + 0.1;
  EXPECT_LE(SearchPose(Table(5), SeenFrom(truth), window).score, window.relevant_score);
}

TEST(SearchPose, LeavesOutExactlyWhatIsExcluded) {
  const Pose2 truth{1.3, 1.1, 0.1};
  SearchWindow window{.centre = truth, .half_width = 0.6, .half_angle = 0.02};
  window.excluded = truth;
  window.excluded_angle = 1.0;
  for (const double distance : {0.12, 0.26, 0.41, 0.58}) {
    window.excluded_distance = distance;
    const SearchResult other = SearchPose(Table(5), SeenFrom(truth), window);
    const double off = Between(truth, other.pose).translation().norm();
    EXPECT_GE(off, distance);
    EXPECT_LT(off, distance + 0.1) << "the score falls with the distance";
  }
}

}  // namespace
}  // namespace enfilade::slam
