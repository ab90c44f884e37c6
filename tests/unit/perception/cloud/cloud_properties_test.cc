// SPDX-License-Identifier: Apache-2.0
// Clouds, neighbours and surfaces against plain implementations.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>

#include "perception/cloud/cloud.h"
#include "perception/cloud/draw_clouds.h"
#include "perception/cloud/nearest_points.h"
#include "perception/cloud/surfels.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/perception/cloud/rooms.h"

namespace enfilade::perception {
namespace {

using ::testing::HasSubstr;

Cloud RandomPoints(std::mt19937& random, std::size_t count, float reach) {
  std::uniform_real_distribution<float> coordinate(-reach, reach);
  Cloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    cloud.points.emplace_back(coordinate(random), coordinate(random), coordinate(random));
  }
  return cloud;
}

TEST(VoxelFilterProperties, KeepsTheMeanOfEachCube) {
  std::mt19937 random(1);
  for (const double voxel : {0.3, 1.0, 7.0}) {
    Cloud cloud = RandomPoints(random, 2000, 5.0F);
    cloud.points[17].x() = NAN;
    cloud.points[99].z() = INFINITY;
    std::map<std::array<int, 3>, std::pair<Eigen::Vector3d, int>> cubes;
    for (const Eigen::Vector3f& point : cloud.points) {
      if (!point.allFinite()) continue;
      const Eigen::Vector3d cell = (point.cast<double>() / voxel).array().floor();
      auto& [sum, count] =
          cubes
              .try_emplace({static_cast<int>(cell.z()), static_cast<int>(cell.y()), static_cast<int>(cell.x())},
                           Eigen::Vector3d::Zero(), 0)
              .first->second;
      sum += point.cast<double>();
      ++count;
    }
    ASSERT_OK_AND_ASSIGN(const Cloud filtered, VoxelFilter(cloud, voxel));
    ASSERT_EQ(filtered.points.size(), cubes.size());
    std::size_t i = 0;
    for (const auto& [cell, mean] : cubes) {  // sorted as the result is
      EXPECT_LT((filtered.points[i].cast<double>() - mean.first / mean.second).norm(), 1e-5);
      ++i;
    }
    std::shuffle(cloud.points.begin(), cloud.points.end(), random);
    ASSERT_OK_AND_ASSIGN(const Cloud shuffled, VoxelFilter(cloud, voxel));
    ASSERT_EQ(shuffled.points.size(), filtered.points.size());
    for (std::size_t k = 0; k < filtered.points.size(); ++k) {
      EXPECT_LT((shuffled.points[k] - filtered.points[k]).norm(), 1e-5F);
    }
  }
}

TEST(VoxelFilterProperties, RefusesPointsTooFarAway) {
  constexpr auto kBad = absl::StatusCode::kInvalidArgument;
  EXPECT_STATUS(VoxelFilter({{{0, 0, 0}}}, 0.0), kBad, HasSubstr("voxel is 0"));
  EXPECT_STATUS(VoxelFilter({{{0, 0, 0}}}, NAN), kBad, HasSubstr("voxel is nan"));
  EXPECT_STATUS(VoxelFilter({{{0, 0, 0}}}, INFINITY), kBad, HasSubstr("voxel is inf"));
  EXPECT_STATUS(VoxelFilter({{{0, 0, 0}, {0, -2e6F, 0}}}, 1.0), kBad, HasSubstr("point 1"));
  EXPECT_OK(VoxelFilter({{{0, 0, 0}, {0, -1e6F, 0}}}, 1.0));
  ASSERT_OK_AND_ASSIGN(const Cloud empty, VoxelFilter({}, 1.0));
  EXPECT_TRUE(empty.points.empty());
}

TEST(TransformedProperties, ComposeAndInvert) {
  std::mt19937 random(2);
  const Cloud cloud = RandomPoints(random, 200, 10.0F);
  const Eigen::Isometry3d A = testing::PoseOf(1.0, -2.0, 0.7, 0.3);
  const Eigen::Isometry3d B = testing::PoseOf(-4.0, 1.0, -2.0, 1.0);
  const Cloud twice = Transformed(Transformed(cloud, A), B);
  const Cloud once = Transformed(cloud, B * A);
  const Cloud back = Transformed(Transformed(cloud, A), A.inverse());
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    EXPECT_LT((twice.points[i] - once.points[i]).norm(), 1e-5F);
    EXPECT_LT((back.points[i] - cloud.points[i]).norm(), 1e-5F);
  }
}

TEST(NearestPointsProperties, AgreeWithAnExhaustiveSearch) {
  std::mt19937 random(3);
  const Cloud cloud = RandomPoints(random, 400, 5.0F);
  ASSERT_OK_AND_ASSIGN(const NearestPoints tree, NearestPoints::Make(cloud.points));
  const Cloud queries = RandomPoints(random, 200, 8.0F);
  for (const Eigen::Vector3f& query : queries.points) {
    std::vector<int> order(cloud.points.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
    const auto distance = [&](int i) { return (cloud.points[static_cast<std::size_t>(i)] - query).squaredNorm(); };
    std::sort(order.begin(), order.end(), [&](int a, int b) { return distance(a) < distance(b); });
    const NearPoint near = tree.Nearest(query);
    EXPECT_EQ(near.index, order[0]);
    EXPECT_NEAR(near.squared_distance, distance(order[0]), 1e-4F);
    const std::vector<int> neighbours = tree.Neighbours(query, 7);
    EXPECT_EQ(neighbours, std::vector<int>(order.begin(), order.begin() + 7));
  }
}

TEST(NearestPointsProperties, HandlesFewPointsAndBadQueries) {
  constexpr auto kBad = absl::StatusCode::kInvalidArgument;
  EXPECT_CODE(NearestPoints::Make({}), kBad);
  EXPECT_CODE(NearestPoints::Make(std::vector<Eigen::Vector3f>{{0, 0, 0}, {0, NAN, 0}}), kBad);
  ASSERT_OK_AND_ASSIGN(const NearestPoints tree,
                       NearestPoints::Make(std::vector<Eigen::Vector3f>{{1, 0, 0}, {3, 0, 0}}));
  EXPECT_EQ(tree.Nearest({0, 0, 0}).index, 0);
  EXPECT_EQ(tree.Neighbours({9, 0, 0}, 10), (std::vector<int>{1, 0}));
  EXPECT_EQ(tree.Nearest({NAN, 0, 0}).index, -1);
  EXPECT_TRUE(tree.Neighbours({INFINITY, 0, 0}, 2).empty());
}

// A patch of points on the plane through the origin with this normal, with noise in m across it.
std::vector<Eigen::Vector3f> Patch(const Eigen::Vector3d& normal, double noise, std::mt19937& random) {
  std::uniform_real_distribution<double> along(-1.0, 1.0);
  std::normal_distribution<double> across(0.0, noise);
  const Eigen::Vector3d u = normal.unitOrthogonal();
  const Eigen::Vector3d v = normal.cross(u);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 300; ++i) {
    points.emplace_back((along(random) * u + along(random) * v + across(random) * normal).cast<float>());
  }
  return points;
}

TEST(SurfelProperties, FindTheNormalOfAPlane) {
  std::mt19937 random(4);
  std::normal_distribution<double> direction;
  for (int trial = 0; trial < 10; ++trial) {
    const Eigen::Vector3d normal =
        Eigen::Vector3d(direction(random), direction(random), direction(random)).normalized();
    const std::vector<Eigen::Vector3f> points = Patch(normal, 1e-4, random);
    ASSERT_OK_AND_ASSIGN(const NearestPoints tree, NearestPoints::Make(points));
    const Surfels surfels = MakeSurfels(points, tree, 15);
    ASSERT_EQ(surfels.points.size(), points.size());
    ASSERT_EQ(surfels.normals.size(), points.size());
    ASSERT_EQ(surfels.flatness.size(), points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_GT(std::abs(surfels.normals[i].dot(normal)), 0.99);
      EXPECT_NEAR(surfels.normals[i].norm(), 1.0, 1e-9);
      // Thin along the normal and of unit extent in the plane.
      EXPECT_NEAR(surfels.covariances[i].trace(), 2.001, 1e-6);
      EXPECT_LT(normal.dot(surfels.covariances[i] * normal), 0.05);
    }
  }
}

TEST(SurfelProperties, DistinguishPlanesFromLinesAndBalls) {
  std::mt19937 random(5);
  const auto mean_flatness = [](const std::vector<Eigen::Vector3f>& points) {
    const NearestPoints tree = NearestPoints::Make(points).value();
    const Surfels surfels = MakeSurfels(points, tree, 20);
    double sum = 0.0;
    for (const double flatness : surfels.flatness) sum += flatness;
    return sum / static_cast<double>(points.size());
  };
  std::vector<Eigen::Vector3f> line;
  for (int i = 0; i < 300; ++i) line.emplace_back(0.01F * static_cast<float>(i), 0.0F, 0.0F);
  const double plane = mean_flatness(Patch(Eigen::Vector3d::UnitZ(), 1e-4, random));
  const double ball = mean_flatness(RandomPoints(random, 300, 1.0F).points);
  EXPECT_GT(plane, 0.5);
  EXPECT_LT(ball, 0.4);
  EXPECT_LT(mean_flatness(line), 0.1);
}

TEST(DrawCloudsTest, DrawsTheTargetBlueAndTheSourceRed) {
  const Cloud target{{{0, 0, 0}, {10, 0, 0}, {10, 6, 0}}};
  const Cloud source{{{0, 0, 1}, {NAN, 0, 0}}};
  const grid::RgbImage image = DrawClouds(source, target, testing::PoseOf(0.0, 6.0, 0.0));
  EXPECT_EQ(image.width, 1000);
  EXPECT_EQ(image.height, 600);
  const auto at = [&](int column, int row) {
    const std::size_t offset = 3 * static_cast<std::size_t>(row * image.width + column);
    return grid::Rgb{image.samples[offset], image.samples[offset + 1], image.samples[offset + 2]};
  };
  EXPECT_EQ(at(0, image.height - 1), grid::kBlue) << "the origin is at the lower left";
  EXPECT_EQ(at(image.width - 1, 0), grid::kBlue);
  EXPECT_EQ(at(0, 0), grid::kRed) << "the source where its pose puts it";
  EXPECT_EQ(DrawClouds({}, {}, Eigen::Isometry3d::Identity()).width, 1);
}

}  // namespace
}  // namespace enfilade::perception
