// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/world/world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "client/simulator/campus/campus_yaml.h"
#include "client/simulator/campus/random_building.h"
#include "core/base/noise.h"
#include "tests/support/status_assertions.h"

namespace enfilade::simulator {
namespace {

std::unique_ptr<const World> ParsedWorld(const char* yaml) {
  absl::StatusOr<Campus> campus = ParseCampus(yaml);
  EXPECT_OK(campus.status());
  return std::make_unique<const World>(*std::move(campus));
}

// Every t at which the ray hits a face, by trying all faces.
std::vector<double> HitsByBruteForce(const LevelWorld& level, const Eigen::Vector2d& from,
                                     const Eigen::Vector2d& direction, double limit, int gate) {
  std::vector<double> hits;
  for (const Face& face : level.faces()) {
    if (face.gate >= 0 && face.gate != gate) continue;
    const Eigen::Vector2d edge = face.b - face.a;
    const double cross = direction.x() * edge.y() - direction.y() * edge.x();
    if (cross == 0.0) continue;
    const Eigen::Vector2d to = face.a - from;
    const double t = (to.x() * edge.y() - to.y() * edge.x()) / cross;
    const double along = (to.x() * direction.y() - to.y() * direction.x()) / cross;
    if (t >= 0.0 && t < limit && along >= 0.0 && along <= 1.0) hits.push_back(t);
  }
  std::sort(hits.begin(), hits.end());
  return hits;
}

std::vector<double> HitsByTraversal(const LevelWorld& level, const Eigen::Vector2d& from,
                                    const Eigen::Vector2d& direction, double limit, int gate) {
  std::vector<double> hits;
  level.Traverse(from, direction, limit, gate, [&](double t, const Face&) {
    hits.push_back(t);
    return true;
  });
  return hits;
}

void ExpectTheSameHits(const World& world, const std::string& id, std::uint64_t seed, int rays) {
  const LevelWorld& level = world.level(id);
  const Eigen::Vector2d extent = level.upper() - level.lower();
  Noise noise(seed);
  for (int i = 0; i < rays; ++i) {
    // Some rays begin outside of the grid, and some are parallel to an axis.
    const Eigen::Vector2d from(level.lower().x() + noise.Uniform(-0.2, 1.2) * extent.x(),
                               level.lower().y() + noise.Uniform(-0.2, 1.2) * extent.y());
    const double angle = noise.Chance(0.2) ? noise.Below(4) * M_PI / 2.0 : noise.Uniform(0.0, 2.0 * M_PI);
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    const double limit = noise.Uniform(0.5, 60.0);
    const std::vector<double> expected = HitsByBruteForce(level, from, direction, limit, -1);
    const std::vector<double> found = HitsByTraversal(level, from, direction, limit, -1);
    ASSERT_TRUE(std::is_sorted(found.begin(), found.end())) << "ray " << i;
    ASSERT_EQ(found, expected) << "ray " << i << " of seed " << seed << " in " << world.campus().name;
  }
}

TEST(LevelWorld, TraversalFindsEveryFaceThatTheRayHits) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) ExpectTheSameHits(World(RandomBuilding(seed)), "ground", seed, 300);
}

TEST(LevelWorld, TraversalStopsWhereTheVisitorWantsIt) {
  const auto world = ParsedWorld(R"(
areas: [{id: a, rect: [0, 0, 10, 4], walls: false}]
walls: [{points: [[2, 0], [2, 4]], thickness: 0}, {points: [[5, 0], [5, 4]], thickness: 0},
        {points: [[8, 0], [8, 4]], thickness: 0}]
)");
  std::vector<double> hits;
  world->level("ground").Traverse({1.0, 2.0}, {1.0, 0.0}, 100.0, -1, [&](double t, const Face&) {
    hits.push_back(t);
    return hits.size() < 2;
  });
  EXPECT_EQ(hits, (std::vector<double>{1.0, 4.0}));
  EXPECT_EQ(HitsByTraversal(world->level("ground"), {1.0, 2.0}, {1.0, 0.0}, 4.0, -1), std::vector<double>{1.0})
      << "the limit is excluded";
  EXPECT_EQ(HitsByTraversal(world->level("ground"), {1.0, 2.0}, {2.0, 0.0}, 100.0, -1).at(0), 0.5)
      << "t is in units of the direction";
}

TEST(LevelWorld, ALiftsDoorIsThereOnlyWhileItMoves) {
  const auto world = ParsedWorld(R"(
levels: {ground: 0, first: 3}
lifts: [{id: lift, rect: [0, 0, 2, 2], side: west, levels: [ground, first]}]
)");
  const LevelWorld& level = world->level("first");
  const int gate = world->GateOf("lift");
  EXPECT_EQ(gate, 0);
  EXPECT_EQ(world->GateOf("stairs"), -1);
  const std::vector<double> open = HitsByTraversal(level, {1.0, 1.0}, {-1.0, 0.0}, 10.0, -1);
  const std::vector<double> closed = HitsByTraversal(level, {1.0, 1.0}, {-1.0, 0.0}, 10.0, gate);
  EXPECT_EQ(closed.size(), open.size() + 1);
  EXPECT_EQ(std::count(closed.begin(), closed.end(), 1.0), 1) << "in the middle of the wall";
  EXPECT_EQ(std::count(open.begin(), open.end(), 1.0), 0);
}

TEST(LevelWorld, DoorsAreCutOutOfEveryWallOnTheirLineAndHaveLintels) {
  const auto world = ParsedWorld(R"(
wall_thickness: 0.2
areas:
  - {id: a, rect: [0, 0, 4, 4], doors: [{id: d, side: east, at: 2, width: 1, height: 2.1}]}
  - {id: b, rect: [4, 0, 4, 4]}
)");
  const LevelWorld& level = world->level("ground");
  const auto lowest = [&](double y) {
    double bottom = 1e9;
    level.Traverse({2.0, y}, {1.0, 0.0}, 4.0, -1, [&](double, const Face& face) {
      bottom = std::min(bottom, face.bottom);
      return true;
    });
    return bottom;
  };
  EXPECT_EQ(lowest(2.0), 2.1) << "the lintel";
  EXPECT_EQ(lowest(0.7), 0.0) << "the wall";
  EXPECT_EQ(lowest(1.49), 0.0);
  EXPECT_EQ(lowest(1.51), 2.1);
}

TEST(LevelWorld, KnowsTheAreaAtAPoint) {
  const auto world = ParsedWorld(R"(
areas:
  - {id: a, rect: [0, 0, 4, 4]}
  - {id: b, rect: [3, 0, 4, 4]}
  - {id: c, rect: [20, 20, 2, 2]}
)");
  const LevelWorld& level = world->level("ground");
  EXPECT_EQ(level.RasterAreaAt(1.0, 1.0), 0);
  EXPECT_EQ(level.RasterAreaAt(3.5, 1.0), 0) << "the first area that contains the point";
  EXPECT_EQ(level.RasterAreaAt(5.0, 1.0), 1);
  EXPECT_EQ(level.RasterAreaAt(21.0, 21.0), 2);
  EXPECT_EQ(level.RasterAreaAt(10.0, 10.0), -1);
  EXPECT_EQ(level.RasterAreaAt(-1e6, 0.0), -1);
  EXPECT_EQ(level.RasterAreaAt(0.0, 1e6), -1);
}

TEST(World, PeopleWalkBackAndForthAtTheirSpeed) {
  const auto world = ParsedWorld(R"(
areas: [{id: a, rect: [0, 0, 20, 20]}]
people:
  - {path: [[1, 1], [5, 1], [5, 4]], speed: 0.5, phase: 2}
  - {path: [[9, 9]], speed: 1}
)");
  const auto at = [&](double seconds) { return world->PeopleOn("ground", seconds).at(0).at; };
  EXPECT_TRUE(at(0.0).isApprox(Eigen::Vector2d(2.0, 1.0))) << "2 s ahead";
  EXPECT_TRUE(at(6.0).isApprox(Eigen::Vector2d(5.0, 1.0)));
  EXPECT_TRUE(at(12.0).isApprox(Eigen::Vector2d(5.0, 4.0)));
  EXPECT_TRUE(at(16.0).isApprox(Eigen::Vector2d(5.0, 2.0))) << "on the way back";
  EXPECT_TRUE(at(26.0).isApprox(Eigen::Vector2d(1.0, 1.0)));
  for (double t = 0.0; t < 60.0; t += 0.1) {
    EXPECT_LE((at(t + 0.1) - at(t)).norm(), 0.05 + 1e-9) << t;
  }
  EXPECT_TRUE(world->PeopleOn("ground", 123.0).at(1).at.isApprox(Eigen::Vector2d(9.0, 9.0))) << "a path of one point";
}

TEST(IntersectCircle, MatchesAMarchAlongTheRay) {
  Noise noise(4);
  int hits = 0;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector2d from(noise.Uniform(-5, 5), noise.Uniform(-5, 5));
    const Eigen::Vector2d centre(noise.Uniform(-5, 5), noise.Uniform(-5, 5));
    const double radius = noise.Uniform(0.1, 1.5);
    const double angle = noise.Uniform(0.0, 2.0 * M_PI);
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    const double t = IntersectCircle(from, direction, centre, radius);
    double marched = kNoHit;
    for (double s = 0.0; s < 20.0 && marched == kNoHit; s += 0.001) {
      if ((from + s * direction - centre).norm() <= radius) marched = s;
    }
    if (std::isinf(marched)) {
      // A grazing ray may be missed by the march, but not by more than its step.
      if (!std::isinf(t)) {
        EXPECT_NEAR((from + t * direction - centre).norm(), radius, 1e-9);
      }
      continue;
    }
    ++hits;
    EXPECT_NEAR(t, marched, 0.0011) << i;
  }
  EXPECT_GT(hits, 20);
  EXPECT_EQ(IntersectCircle({0.0, 0.0}, {1.0, 0.0}, {0.1, 0.0}, 0.5), 0.0) << "inside";
  EXPECT_EQ(IntersectCircle({0.0, 0.0}, {1.0, 0.0}, {-2.0, 0.0}, 0.5), kNoHit) << "behind";
}

}  // namespace
}  // namespace enfilade::simulator
