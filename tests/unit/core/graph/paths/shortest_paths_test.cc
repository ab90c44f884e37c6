// SPDX-License-Identifier: Apache-2.0
#include "core/graph/paths/shortest_paths.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/graph/global_pose.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/graph/scene.h"

namespace enfilade::graph {
namespace {

using testing::AnchorIn;
using ::testing::ElementsAre;
using testing::Graph;
using ::testing::IsEmpty;
using testing::Joining;
using testing::L;
using testing::M;
using testing::Numbered;
using testing::PoseNear;
using testing::Uniform;

std::vector<std::string> LinkPointsOf(const GraphSnapshot& graph, const Path& path) {
  std::vector<std::string> ids;
  for (const int slot : path.link_points) ids.push_back(graph.link_point_node(slot).link_point->id.value());
  return ids;
}
std::vector<std::string> MapsOf(const GraphSnapshot& graph, const Path& path) {
  std::vector<std::string> ids;
  for (const int slot : path.maps) ids.push_back(graph.map_node(slot).map->id.value());
  return ids;
}

std::optional<Path> Find(const GraphSnapshot& graph, const std::string& from, const std::string& to,
                         const PathOptions& options = {}, const Eigen::Vector2d& start = {0, 0},
                         const Eigen::Vector2d& goal = {0, 0}) {
  return ShortestPath(graph, {{.map = graph.MapSlot(M(from)), .cost = 0.0, .position = start}},
                      {.map = graph.MapSlot(M(to)), .position = goal}, options);
}

Eigen::Matrix3d Diagonal(double position, double yaw) { return Eigen::Vector3d(position, position, yaw).asDiagonal(); }

// Two ways from a to c: over b, short but uncertain, and over d and e, long and certain.
GraphSnapshot TwoWays() {
  const Eigen::Matrix3d bad = Diagonal(0.5, 0.1);
  const Eigen::Matrix3d good = Diagonal(0.001, 0.0001);
  return Graph({"a", "b", "c", "d", "e"},
               {Joining("ab", {AnchorIn("a", {1, 0, 0}, bad), AnchorIn("b", {0, 0, 0}, bad)}),
                Joining("bc", {AnchorIn("b", {1, 0, 0}, bad), AnchorIn("c", {0, 0, 0}, bad)}),
                Joining("ad", {AnchorIn("a", {9, 0, 0}, good), AnchorIn("d", {0, 0, 0}, good)}),
                Joining("de", {AnchorIn("d", {9, 0, 0}, good), AnchorIn("e", {0, 0, 0}, good)}),
                Joining("ec", {AnchorIn("e", {9, 0, 0}, good), AnchorIn("c", {9, 0, 0}, good)})});
}

TEST(ShortestPathsTest, EachCostHasItsOwnWay) {
  const GraphSnapshot graph = TwoWays();
  const Path certain = Find(graph, "a", "c").value();
  EXPECT_THAT(LinkPointsOf(graph, certain), ElementsAre("ad", "de", "ec"));
  EXPECT_THAT(MapsOf(graph, certain), ElementsAre("a", "d", "e", "c"));
  const Path near = Find(graph, "a", "c", {.cost = PathCost::kDistance}).value();
  EXPECT_THAT(LinkPointsOf(graph, near), ElementsAre("ab", "bc"));
  EXPECT_DOUBLE_EQ(near.cost, 2.0);
  EXPECT_DOUBLE_EQ(Find(graph, "a", "c", {.cost = PathCost::kHops}).value().cost, 2.0);
}

TEST(ShortestPathsTest, UncertaintyCountsTheYawAtItsLever) {
  const GraphSnapshot graph = Graph(
      {"a", "b"},
      {Joining("x", {AnchorIn("a", {1, 0, 0}, Diagonal(0.1, 0.01)), AnchorIn("b", {0, 4, 0}, Diagonal(0.2, 0.02))})});
  // At the start the lever is the one given, at the goal the real one.
  EXPECT_DOUBLE_EQ(Find(graph, "a", "b", {.lever_m = 7.0}, {0, 0}, {3, 0}).value().cost,
                   0.2 + 0.01 * 49.0 + 0.4 + 0.02 * 25.0);
}

TEST(ShortestPathsTest, APathWithinOneMapHasNoLinkPoints) {
  const Path path = Find(TwoWays(), "a", "a", {.cost = PathCost::kDistance}, {0, 0}, {3, 4}).value();
  EXPECT_THAT(path.link_points, IsEmpty());
  EXPECT_DOUBLE_EQ(path.cost, 5.0);
}

TEST(ShortestPathsTest, ReturnsNoPathIfThereIsNoWay) {
  const GraphSnapshot graph = Graph({"a", "b"}, {Joining("x", {AnchorIn("a", {})})});
  EXPECT_EQ(Find(graph, "a", "b"), std::nullopt);
}

TEST(ShortestPathsTest, ALiftJoinsThreeMaps) {
  const GraphSnapshot graph =
      Graph({"f0", "f1", "f2"},
            {Joining("lift", {AnchorIn("f0", {5, 0, 0}), AnchorIn("f1", {5, 0, 0}), AnchorIn("f2", {5, 0, 0})})});
  for (const char* from : {"f0", "f1", "f2"}) {
    for (const char* to : {"f0", "f1", "f2"}) {
      if (std::string(from) == to) continue;
      EXPECT_THAT(LinkPointsOf(graph, Find(graph, from, to).value()), ElementsAre("lift")) << from << to;
    }
  }
}

// Ids are neither indices into a path or list, nor contiguous, nor below 100.
TEST(ShortestPathsTest, IdsInAPathAreArbitrary) {
  const GraphSnapshot graph =
      Graph({"42", "100", "7", "101"}, {Joining("900", {AnchorIn("42", {1, 2, 0.5}), AnchorIn("100", {3, 1, -1})}),
                                        Joining("3", {AnchorIn("100", {5, 5, 2}), AnchorIn("7", {0, 1, 1})}),
                                        Joining("101", {AnchorIn("7", {4, 4, 0}), AnchorIn("101", {2, 2, 3})})});
  const Path path = Find(graph, "42", "101").value();
  EXPECT_THAT(LinkPointsOf(graph, path), ElementsAre("900", "3", "101"));
  EXPECT_THAT(MapsOf(graph, path), ElementsAre("42", "100", "7", "101"));
  const Pose2 expected = Pose2{1, 2, 0.5} * Inverse(Pose2{3, 1, -1}) * Pose2{5, 5, 2} * Inverse(Pose2{0, 1, 1}) *
                         Pose2{4, 4, 0} * Inverse(Pose2{2, 2, 3});
  EXPECT_THAT(ChainAlong(graph, path, {}, {}).T_start_end.pose, PoseNear(expected, 1e-12, 1e-12));
}

TEST(ShortestPathsTest, LengthsBelowAMetreCount) {
  // Two paths with the same number of doors, 0.9 m and 0.3 m long: truncated to integers both would cost nothing.
  const GraphSnapshot graph =
      Graph({"a", "b", "c", "d"}, {Joining("a1", {AnchorIn("a", {0, 0, 0}), AnchorIn("b", {0, 0, 0})}),
                                   Joining("b1", {AnchorIn("b", {0.9, 0, 0}), AnchorIn("d", {0, 0, 0})}),
                                   Joining("a2", {AnchorIn("a", {0, 0, 0}), AnchorIn("c", {0, 0, 0})}),
                                   Joining("c2", {AnchorIn("c", {0.3, 0, 0}), AnchorIn("d", {0, 0, 0})})});
  const Path path = Find(graph, "a", "d", {.cost = PathCost::kDistance}).value();
  EXPECT_THAT(LinkPointsOf(graph, path), ElementsAre("a2", "c2"));
  EXPECT_DOUBLE_EQ(path.cost, 0.3);
}

TEST(ShortestPathsTest, EdgesThroughTwoSharedMapsAreDistinct) {
  // x and y both join b and c: 6 m apart in one, 2 m (around the corner) in the other.
  const GraphSnapshot graph =
      Graph({"a", "b", "c", "d"},
            {Joining("in", {AnchorIn("a", {0, 0, 0}), AnchorIn("b", {-1, 0, 0})}),
             Joining("x", {AnchorIn("b", {0, 0, 0}), AnchorIn("c", {0, 0, 0})}),
             Joining("y", {AnchorIn("b", {60, 0, 0}), AnchorIn("c", {2, 0, 0}), AnchorIn("d", {0, 0, 0})})});
  const Path path = Find(graph, "a", "d", {.cost = PathCost::kDistance}).value();
  EXPECT_THAT(LinkPointsOf(graph, path), ElementsAre("in", "x", "y"));
  EXPECT_THAT(MapsOf(graph, path), ElementsAre("a", "b", "c", "d"));
  EXPECT_DOUBLE_EQ(path.cost, 3.0);
}

TEST(ShortestPathsTest, EqualWaysAreChosenByIdsNotByHistory) {
  const auto door = [](const std::string& id, const std::string& a, const std::string& b) {
    return Joining(id, {AnchorIn(a, {}), AnchorIn(b, {})});
  };
  std::vector<LinkPoint> doors = {door("p", "a", "b"), door("q", "a", "c"), door("r", "b", "d"), door("s", "c", "d"),
                                  door("t", "d", "e")};
  const GraphSnapshot forth = Graph({"a", "b", "c", "d", "e"}, doors);
  std::reverse(doors.begin(), doors.end());
  const GraphSnapshot back = Graph({"e", "d", "c", "b", "a"}, doors);
  EXPECT_THAT(LinkPointsOf(forth, Find(forth, "a", "e").value()), ElementsAre("p", "r", "t"));
  EXPECT_THAT(LinkPointsOf(back, Find(back, "a", "e").value()), ElementsAre("p", "r", "t"));
}

TEST(ShortestPathsTest, ClosedDoorsAreNotPassedWhileTheyAreClosed) {
  LinkPoint closed = Joining("x", {AnchorIn("a", {}), AnchorIn("b", {})});
  closed.state = PassageState::kClosed;
  closed.state_valid_until = 100;
  LinkPoint blocked = Joining("y", {AnchorIn("b", {}), AnchorIn("c", {})});
  blocked.state = PassageState::kBlocked;
  const GraphSnapshot graph = Graph({"a", "b", "c"}, {closed, blocked});
  EXPECT_TRUE(Find(graph, "a", "c").has_value());
  EXPECT_FALSE(Find(graph, "a", "b", {.passable_at = 99}).has_value());
  EXPECT_TRUE(Find(graph, "a", "b", {.passable_at = 100}).has_value());
  EXPECT_FALSE(Find(graph, "a", "c", {.passable_at = 100}).has_value());
}

// Bellman-Ford over explicit edges.
double Reference(const std::vector<LinkPoint>& doors, const std::string& from, const std::string& to, PathCost cost) {
  const double kFar = std::numeric_limits<double>::infinity();
  const auto spread = [](const Anchor& a) {
    return a.covariance(0, 0) + a.covariance(1, 1) + 100.0 * a.covariance(2, 2);
  };
  const auto leg = [&](const Anchor& a, const Anchor& b) {
    if (cost == PathCost::kHops) return 1.0;
    if (cost == PathCost::kDistance) return (a.T_map_place.translation() - b.T_map_place.translation()).norm();
    return spread(a) + spread(b);
  };
  std::vector<double> best(doors.size(), kFar);
  for (std::size_t i = 0; i < doors.size(); ++i) {
    const Anchor* first = doors[i].FindAnchor(M(from));
    if (first == nullptr) continue;
    best[i] = cost == PathCost::kHops       ? 1.0
              : cost == PathCost::kDistance ? first->T_map_place.translation().norm()
                                            : spread(*first);
  }
  for (std::size_t round = 0; round < doors.size(); ++round) {
    for (std::size_t i = 0; i < doors.size(); ++i) {
      for (std::size_t j = 0; j < doors.size(); ++j) {
        if (i == j) continue;
        for (const Anchor& a : doors[i].anchors) {
          const Anchor* b = doors[j].FindAnchor(a.map);
          if (b != nullptr) best[j] = std::min(best[j], best[i] + leg(a, *b));
        }
      }
    }
  }
  double end = kFar;
  for (std::size_t i = 0; i < doors.size(); ++i) {
    const Anchor* last = doors[i].FindAnchor(M(to));
    if (last == nullptr) continue;
    end = std::min(end, best[i] + (cost == PathCost::kHops       ? 0.0
                                   : cost == PathCost::kDistance ? last->T_map_place.translation().norm()
                                                                 : spread(*last)));
  }
  return end;
}

TEST(ShortestPathsTest, AgreesWithAReferenceOnRandomGraphs) {
  std::mt19937_64 random(3);
  int found = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const testing::World world = testing::RandomWorld(12, 60.0, random);
    std::vector<LinkPoint> doors;
    for (int i = 0; i < 15; ++i) {
      const int a = static_cast<int>(random() % 12);
      const int b = (a + 1 + static_cast<int>(random() % 11)) % 12;
      const Pose2 place{Uniform(0, 60, random), Uniform(0, 60, random), Uniform(-3, 3, random)};
      const Eigen::Matrix3d S = Diagonal(Uniform(1e-4, 1e-3, random), 1e-5);
      doors.push_back(world.See(Numbered("l", i * 37 % 101), place, {a, b}, {S, S}, random));
    }
    const GraphSnapshot graph = Graph(world.MapIds(), doors);
    for (const PathCost cost : {PathCost::kDistance, PathCost::kHops}) {
      const double expected = Reference(doors, "m0", "m5", cost);
      const auto path = Find(graph, "m0", "m5", {.cost = cost});
      ASSERT_EQ(path.has_value(), std::isfinite(expected));
      if (!path.has_value()) continue;
      ++found;
      // A reference path may also turn round inside a map; places differ by centimetres between maps.
      EXPECT_NEAR(path->cost, expected, 0.5);
      EXPECT_GE(path->cost, expected - 1e-9);
      EXPECT_NEAR(CostOf(graph, {.map = graph.MapSlot(M("m0")), .cost = 0.0, .position = Eigen::Vector2d(0, 0)}, *path,
                         {.map = graph.MapSlot(M("m5")), .position = Eigen::Vector2d(0, 0)}, {.cost = cost}),
                  path->cost, 1e-9);
    }
    // Without a place in the goal's map its lever is the fixed one.
    const auto certain = ShortestPath(graph, {{.map = graph.MapSlot(M("m0"))}}, {.map = graph.MapSlot(M("m5"))}, {});
    if (certain.has_value()) {
      EXPECT_NEAR(certain->cost, Reference(doors, "m0", "m5", PathCost::kUncertainty), 1e-9);
    }
  }
  EXPECT_GT(found, 60);
}

}  // namespace
}  // namespace enfilade::graph
