// SPDX-License-Identifier: Apache-2.0
#include "core/slam/matching/likelihood_field.h"

#include <gtest/gtest.h>

#include <cmath>

namespace enfilade::slam {
namespace {

// Points every 1 cm along the line through `p` with direction `yaw`: a wall.
std::vector<Eigen::Vector2d> WallPoints(const Eigen::Vector2d& p, double yaw, double length) {
  std::vector<Eigen::Vector2d> points;
  for (double s = -length / 2; s <= length / 2; s += 0.01)
    points.push_back(p + s * Eigen::Vector2d(std::cos(yaw), std::sin(yaw)));
  return points;
}

TEST(LikelihoodField, IsTheSquaredDistanceToAStraightWallFarBelowACell) {
  for (const double yaw : {0.0, 0.3, 1.1, M_PI / 2}) {
    LikelihoodField field(0.05, 0.5);
    const Eigen::Vector2d on_wall(0.513, -0.287);
    field.Add(WallPoints(on_wall, yaw, 6.0));
    const Eigen::Vector2d normal(-std::sin(yaw), std::cos(yaw));
    for (double d = -0.3; d <= 0.3; d += 0.013) {
      const auto sample = field.At(on_wall + d * normal);
      EXPECT_NEAR(sample.squared_distance, d * d, 1e-4) << "yaw " << yaw << " d " << d;
      EXPECT_NEAR(sample.gradient.dot(normal), 2.0 * d, 0.01) << "yaw " << yaw << " d " << d;
    }
  }
}

TEST(LikelihoodField, HasTheGradientOfItsInterpolation) {
  LikelihoodField field(0.1, 1.0);
  field.Add({{0.03, 0.04}, {0.55, 0.71}, {-0.4, 0.2}});
  for (double x = -0.6; x < 0.8; x += 0.037) {
    for (double y = -0.3; y < 0.9; y += 0.041) {
      const double h = 1e-6;
      const Eigen::Vector2d numeric(
          (field.At({x + h, y}).squared_distance - field.At({x - h, y}).squared_distance) / (2 * h),
          (field.At({x, y + h}).squared_distance - field.At({x, y - h}).squared_distance) / (2 * h));
      const auto sample = field.At({x, y});
      if (sample.squared_distance < 1e-4) continue;  // clamped at zero there
      EXPECT_LT((sample.gradient - numeric).norm(), 1e-6) << x << " " << y;
    }
  }
}

TEST(LikelihoodField, IsFarEverywhereElse) {
  LikelihoodField field(0.05, 0.5);
  EXPECT_DOUBLE_EQ(field.At({3.0, 4.0}).squared_distance, 0.25);
  field.Add({{0.0, 0.0}});
  EXPECT_NEAR(field.At({0.75, 0.0}).squared_distance, 0.25, 1e-6);
  EXPECT_DOUBLE_EQ(field.At({1e300, NAN}).squared_distance, 0.25);
}

TEST(LikelihoodField, UpdatedByPartsIsTheSameAsMadeAtOnce) {
  SubmapGrid grid(0.05, {});
  LikelihoodField updated(0.05, 0.5);
  std::vector<grid::CellIndex> all;
  for (int scan = 0; scan < 20; ++scan) {
    grid::ScanRays rays;
    for (int i = 0; i < 60; ++i) {
      const double angle = 0.05 * i;
      // Walls come and go: cells turn from occupied to free again.
      const double range = 2.0 + 0.5 * std::sin(3.0 * angle) + 0.3 * (scan % 3);
      rays.hits.emplace_back(range * std::cos(angle), range * std::sin(angle));
    }
    const auto changed = grid.Insert({0.1 * scan, 0.05 * scan, 0.02 * scan}, rays);
    ASSERT_TRUE(changed.ok());
    updated.Update(grid, *changed);
  }
  for (const auto& [key, hit] : grid.hits()) all.push_back({key.second, key.first});
  LikelihoodField made(0.05, 0.5);
  made.Update(grid, all);
  EXPECT_EQ(updated.window(), made.window());
  EXPECT_EQ(updated.squared_distances(), made.squared_distances());
}

}  // namespace
}  // namespace enfilade::slam
