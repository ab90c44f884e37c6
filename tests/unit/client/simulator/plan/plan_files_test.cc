// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/plan/plan_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "client/simulator/plan/campus_plan.h"
#include "client/simulator/plan/deformed_plan.h"
#include "client/simulator/simulation_files.h"
#include "core/prior/formats/building_plan.h"
#include "core/prior/formats/geojson_plan.h"
#include "core/prior/formats/svg_plan.h"
#include "core/prior/plan/planar.h"
#include "io/file.h"
#include "nlohmann/json.hpp"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::simulator {
namespace {

using enfilade::testing::TemporaryDirectory;

prior::PlanGraph PlanOfRandom(int seed) {
  const Campus campus = LoadCampus("random:" + std::to_string(seed)).value();
  return PlanOf(campus, campus.levels.begin()->first);
}

class CampusPlan : public ::testing::TestWithParam<int> {};

TEST_P(CampusPlan, IsPlanarAndLeavesDoorsOpen) {
  const prior::PlanGraph plan = PlanOfRandom(GetParam());
  EXPECT_TRUE(prior::Validate(plan).ok());
  EXPECT_TRUE(prior::IsPlanar(plan));
  ASSERT_FALSE(plan.doors.empty());
  for (const prior::PlanDoor& door : plan.doors) {
    const Eigen::Vector2d middle = (door.from + door.to) / 2;
    for (const prior::PlanWall& wall : plan.walls) {
      const Eigen::Vector2d a = plan.corners[static_cast<std::size_t>(wall.from)].point;
      const Eigen::Vector2d way = plan.corners[static_cast<std::size_t>(wall.to)].point - a;
      const double t = std::clamp((middle - a).dot(way) / way.squaredNorm(), 0.0, 1.0);
      EXPECT_GT((middle - a - t * way).norm(), 0.3);
    }
  }
}

TEST_P(CampusPlan, DeformedKnowsWhereItsCornersAre) {
  const prior::PlanGraph built = PlanOfRandom(GetParam());
  const DeformedPlan plan = Deform(built, {.seed = static_cast<std::uint64_t>(GetParam())});
  EXPECT_TRUE(prior::Validate(plan.graph).ok());
  ASSERT_EQ(plan.corners.size(), plan.graph.corners.size());
  ASSERT_EQ(plan.invented.size(), plan.graph.walls.size());
  // Corners of walls that are there are corners of the building.
  double widest = 0;
  for (std::size_t i = 0; i < plan.graph.walls.size(); ++i) {
    if (plan.invented[i]) continue;
    for (const int end : {plan.graph.walls[i].from, plan.graph.walls[i].to}) {
      const Eigen::Vector2d corner = plan.corners[static_cast<std::size_t>(end)];
      double nearest = 1e9;
      for (const prior::PlanCorner& one : built.corners) {
        nearest = std::min(nearest, (ToCampus(one.point) - corner).norm());
      }
      EXPECT_LT(nearest, 1e-9);
      widest = std::max(widest, plan.graph.corners[static_cast<std::size_t>(end)].point.norm());
    }
  }
  EXPECT_GT(widest, 100) << "pixels";
  EXPECT_EQ(plan.left_out.size() + plan.graph.walls.size() -
                static_cast<std::size_t>(std::count(plan.invented.begin(), plan.invented.end(), true)),
            built.walls.size());
}

INSTANTIATE_TEST_SUITE_P(Buildings, CampusPlan, ::testing::Range(11, 19));

TEST(PlanDeformation, WithoutFaultsThePlanIsTheBuilding) {
  const prior::PlanGraph built = PlanOfRandom(7);
  const DeformedPlan plan = Deform(built, PlanDeformation::None());
  ASSERT_EQ(plan.graph.walls.size(), built.walls.size());
  for (std::size_t i = 0; i < plan.corners.size(); ++i) {
    const Eigen::Vector2d way = plan.graph.corners[i].point - plan.graph.corners[0].point;
    const Eigen::Vector2d true_way = plan.corners[i] - plan.corners[0];
    EXPECT_NEAR(way.x(), 25 * true_way.x(), 1e-6);
    EXPECT_NEAR(way.y(), -25 * true_way.y(), 1e-6);
  }
}

TEST(PlanDeformation, EachKindOfFaultIsMade) {
  const prior::PlanGraph built = PlanOfRandom(7);
  int mirrored = 0;
  std::set<bool> invented;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const DeformedPlan plan = Deform(built, {.seed = seed});
    mirrored += plan.mirrored ? 1 : 0;
    EXPECT_FALSE(plan.left_out.empty());
    for (const bool one : plan.invented) invented.insert(one);
  }
  EXPECT_GT(mirrored, 0);
  EXPECT_LT(mirrored, 12) << "one of ten";
  EXPECT_EQ(invented.size(), 2U);
  // The same seed, the same plan.
  EXPECT_EQ(prior::WriteGeoJsonPlan(Deform(built, {.seed = 3}).graph),
            prior::WriteGeoJsonPlan(Deform(built, {.seed = 3}).graph));
}

// Walls of both have the same ends, within `tolerance`.
void ExpectSameWalls(const prior::PlanGraph& a, const prior::PlanGraph& b, double tolerance) {
  ASSERT_EQ(a.walls.size(), b.walls.size());
  const auto end = [](const prior::PlanGraph& plan, int corner) {
    return plan.corners[static_cast<std::size_t>(corner)].point;
  };
  for (const prior::PlanWall& wall : a.walls) {
    const bool found = std::any_of(b.walls.begin(), b.walls.end(), [&](const prior::PlanWall& other) {
      const auto near = [&](int mine, int yours) { return (end(a, mine) - end(b, yours)).norm() < tolerance; };
      return (near(wall.from, other.from) && near(wall.to, other.to)) ||
             (near(wall.from, other.to) && near(wall.to, other.from));
    });
    EXPECT_TRUE(found) << end(a, wall.from).transpose() << " to " << end(a, wall.to).transpose();
  }
}

TEST(PlanFiles, AllFormatsHaveTheSameWalls) {
  const TemporaryDirectory directory;
  const Campus campus = LoadCampus("random:7").value();
  ASSERT_OK(WritePlanFiles(campus, {.seed = 5}, directory.path()));
  const auto read = [&](const char* name) { return io::ReadFile(directory.path() / name).value(); };
  const auto plan = prior::ReadGeoJsonPlan(read("plan.geojson"));
  ASSERT_OK(plan.status());
  const auto svg = prior::ReadSvgPlan(read("plan.svg"));
  ASSERT_OK(svg.status());
  ExpectSameWalls(*plan, svg->graph, 0.01);
  const auto building = prior::ParseBuilding(read("plan.building.yaml"));
  ASSERT_OK(building.status());
  const prior::PlanGraph of_building = prior::PlanOfLevel(*building, 0);
  ExpectSameWalls(*plan, of_building, 0.01);
  EXPECT_EQ(of_building.doors.size(), plan->doors.size());
  EXPECT_NEAR(*of_building.metres_per_unit, 0.04, 1e-4);
  const nlohmann::json truth = nlohmann::json::parse(read("plan-truth.json"));
  EXPECT_EQ(truth["walls"].size(), plan->walls.size());
  EXPECT_EQ(truth["corners"].size(), plan->corners.size());
}

TEST(PlanFiles, EachLevelHasItsPlan) {
  const TemporaryDirectory directory;
  const Campus campus = LoadCampus("levels").value();
  ASSERT_OK(WritePlanFiles(campus, PlanDeformation::None(), directory.path()));
  for (const auto& [level, height] : campus.levels) {
    EXPECT_TRUE(std::filesystem::exists(directory.path() / (level + "-filled.png"))) << level;
    const auto plan = prior::ReadGeoJsonPlan(io::ReadFile(directory.path() / (level + ".geojson")).value());
    ASSERT_OK(plan.status());
    EXPECT_FALSE(plan->shafts.empty()) << "the lift";
  }
}

}  // namespace
}  // namespace enfilade::simulator
