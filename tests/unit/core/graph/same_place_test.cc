// SPDX-License-Identifier: Apache-2.0
#include "core/graph/same_place.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace enfilade::graph {
namespace {

Anchor At(const std::string& map, double x, double y, double variance = 0.0, double yaw = 0.0) {
  return {MapId(map), {x, y, yaw}, Eigen::Vector3d(variance, variance, 0.01).asDiagonal()};
}

Eigen::Matrix3d Rotated(double major, double minor, double angle) {
  Eigen::Matrix2d R;
  R << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  covariance.topLeftCorner<2, 2>() = R * Eigen::Vector2d(major, minor).asDiagonal() * R.transpose();
  return covariance;
}

TEST(SamePlaceDistanceTest, IsTheCircleOfBothUncertainties) {
  const Eigen::Matrix3d zero = Eigen::Matrix3d::Zero();
  EXPECT_DOUBLE_EQ(SamePlaceDistance(zero, zero), kMinSamePlaceDistance);
  // 95 % of a difference with a standard deviation of 0.5 m lie within 1.22 m.
  const Eigen::Matrix3d quarter = Eigen::Vector3d(0.25, 0.25, 9.0).asDiagonal();
  EXPECT_NEAR(SamePlaceDistance(quarter, zero), std::sqrt(5.991 * 0.25), 1e-12);
  EXPECT_NEAR(SamePlaceDistance(quarter, quarter), std::sqrt(5.991 * 0.5), 1e-12);
}

TEST(SamePlaceDistanceTest, FollowsTheLargerAxisWhateverItsDirection) {
  for (int i = 0; i < 12; ++i) {
    const Eigen::Matrix3d a = Rotated(0.4, 0.001, 0.3 * i);
    EXPECT_NEAR(SamePlaceDistance(a, Eigen::Matrix3d::Zero()), std::sqrt(5.991 * 0.4), 1e-9) << i;
  }
  // Two thin ellipses across each other add up to a round one.
  EXPECT_NEAR(SamePlaceDistance(Rotated(0.4, 0.0, 0.0), Rotated(0.4, 0.0, M_PI / 2)), std::sqrt(5.991 * 0.4), 1e-9);
}

TEST(SamePlaceDistanceTest, OnlyGrowsWithUncertaintyAndIsSymmetric) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> variance(0.0, 1.0), angle(-3.0, 3.0);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Matrix3d a = Rotated(variance(random), variance(random), angle(random));
    const Eigen::Matrix3d b = Rotated(variance(random), variance(random), angle(random));
    EXPECT_DOUBLE_EQ(SamePlaceDistance(a, b), SamePlaceDistance(b, a));
    EXPECT_GE(SamePlaceDistance(a, b) + 1e-12, SamePlaceDistance(a, Eigen::Matrix3d::Zero()));
  }
}

TEST(FindCommonPlaceTest, NeedsTwoMapsAndAllOfThemToAgree) {
  const std::vector<Anchor> door = {At("hall", 10, 0), At("lab", 0, 0)};
  struct Case {
    std::string name;
    std::vector<Anchor> other;
    int maps;  // 0: no common place
    double distance;
  };
  const std::vector<Case> cases = {
      {"the same", door, 2, 0.0},
      {"the anchors in another order, 0.2 m off in one map", {At("lab", 0, 0.2), At("hall", 10, 0)}, 2, 0.2},
      {"exactly the least distance apart", {At("hall", 10, 0), At("lab", 0.3, 0)}, 2, 0.3},
      {"the second door of a room", {At("hall", 12, 0), At("lab", 2, 0)}, 0, 0.0},
      {"the same place in one of the maps only", {At("hall", 10, 0), At("lab", 20, 0)}, 0, 0.0},
      {"another pair of maps", {At("hall", 10, 0), At("yard", 0, 0)}, 0, 0.0},
      {"a candidate", {At("hall", 10, 0)}, 0, 0.0},
      {"a lift that goes on to a third map", {At("hall", 10, 0.1), At("lab", 0, 0), At("yard", 5, 5)}, 2, 0.1},
      {"no anchors", {}, 0, 0.0},
  };
  for (const Case& test : cases) {
    for (const auto& place : {FindCommonPlace(door, test.other), FindCommonPlace(test.other, door)}) {
      ASSERT_EQ(place.has_value(), test.maps > 0) << test.name;
      if (!place) continue;
      EXPECT_EQ(place->map_count, test.maps) << test.name;
      EXPECT_NEAR(place->distance, test.distance, 1e-9) << test.name;
    }
  }
}

TEST(FindCommonPlaceTest, WhatIsLessCertainIsTheSameFromFartherAway) {
  const std::vector<Anchor> door = {At("hall", 10, 0, 0.01), At("lab", 0, 0, 0.01)};
  const std::vector<Anchor> other = {At("hall", 11.1, 0, 0.01), At("lab", 1.1, 0, 0.01)};
  EXPECT_FALSE(FindCommonPlace(door, other));
  std::vector<Anchor> vague = other;
  for (Anchor& anchor : vague) anchor.covariance = Eigen::Vector3d(0.25, 0.25, 0.01).asDiagonal();
  EXPECT_TRUE(FindCommonPlace(door, vague));
  vague[1] = other[1];
  EXPECT_FALSE(FindCommonPlace(door, vague)) << "every map has its own limit";
}

TEST(FindCommonPlaceTest, DirectionsDoNotMatter) {
  EXPECT_TRUE(
      FindCommonPlace({At("hall", 1, 0, 0.0, 0.0), At("lab", 0, 0)}, {At("hall", 1, 0, 0.0, 3.0), At("lab", 0, 0)}));
}

TEST(FindCommonPlaceTest, ThreeMapsAllCount) {
  const std::vector<Anchor> lift = {At("a", 0, 0), At("b", 0, 0), At("c", 0, 0)};
  const auto same = FindCommonPlace(lift, {At("c", 0, 0.25), At("a", 0.1, 0), At("b", 0, 0)});
  ASSERT_TRUE(same);
  EXPECT_EQ(same->map_count, 3);
  EXPECT_NEAR(same->distance, 0.25, 1e-12);
  EXPECT_FALSE(FindCommonPlace(lift, {At("c", 0, 5), At("a", 0.1, 0), At("b", 0, 0)}));
}

}  // namespace
}  // namespace enfilade::graph
