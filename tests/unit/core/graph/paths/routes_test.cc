// SPDX-License-Identifier: Apache-2.0
#include "core/graph/paths/routes.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <functional>
#include <set>

#include "core/graph/paths/k_shortest_paths.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/graph/scene.h"

namespace enfilade::graph {
namespace {

using testing::AnchorIn;
using testing::Graph;
using ::testing::IsEmpty;
using testing::Joining;
using testing::L;
using testing::M;
using testing::Numbered;
using ::testing::SizeIs;
using testing::Uniform;

// Two rooms on a corridor, with a door of their own between them.
GraphSnapshot Corridor(PassageState between = PassageState::kOpen) {
  LinkPoint direct = Joining("between", {AnchorIn("r1", {4, 0, 0}), AnchorIn("r2", {0, 0, 0})});
  direct.state = between;
  return Graph({"r1", "corridor", "r2"},
               {Joining("d1", {AnchorIn("r1", {2, -3, 0}), AnchorIn("corridor", {2, 0, 0})}),
                Joining("d2", {AnchorIn("r2", {2, -3, 0}), AnchorIn("corridor", {8, 0, 0})}), direct});
}

RouteRequest FromR1ToR2() {
  return {.from_map = M("r1"), .T_from_map_start = {1, 0, 0}, .to_map = M("r2"), .T_to_map_goal = {3, 0, 1}};
}

TEST(RoutesTest, GivesEachLegInTheFrameOfItsMap) {
  ASSERT_OK_AND_ASSIGN(const Routes routes, FindRoutes(Corridor(PassageState::kClosed), FromR1ToR2(), {}));
  EXPECT_EQ(routes.graph_version, 1);
  ASSERT_THAT(routes.routes, SizeIs(1));
  const std::vector<RouteLeg>& legs = routes.routes[0].legs;
  ASSERT_THAT(legs, SizeIs(3));
  EXPECT_EQ(legs[0].map, M("r1"));
  EXPECT_EQ(legs[0].T_map_begin, (Pose2{1, 0, 0}));
  EXPECT_EQ(legs[0].T_map_end, (Pose2{2, -3, 0}));
  EXPECT_EQ(legs[0].exit, L("d1"));
  EXPECT_EQ(legs[1].map, M("corridor"));
  EXPECT_EQ(legs[1].T_map_begin, (Pose2{2, 0, 0}));
  EXPECT_EQ(legs[1].T_map_end, (Pose2{8, 0, 0}));
  EXPECT_DOUBLE_EQ(legs[1].length_m, 6.0);
  EXPECT_EQ(legs[2].T_map_begin, (Pose2{2, -3, 0}));
  EXPECT_EQ(legs[2].T_map_end, (Pose2{3, 0, 1}));
  EXPECT_TRUE(legs[2].exit.empty());
  EXPECT_DOUBLE_EQ(routes.routes[0].length_m, legs[0].length_m + 6.0 + legs[2].length_m);
  EXPECT_DOUBLE_EQ(routes.routes[0].cost, routes.routes[0].length_m);
}

TEST(RoutesTest, GivesAlternativesTheBestFirst) {
  ASSERT_OK_AND_ASSIGN(const Routes routes, FindRoutes(Corridor(), FromR1ToR2(), {.max_routes = 5}));
  ASSERT_THAT(routes.routes, SizeIs(2));
  EXPECT_EQ(routes.routes[0].legs[0].exit, L("between"));
  EXPECT_EQ(routes.routes[1].legs[0].exit, L("d1"));
  EXPECT_LT(routes.routes[0].length_m, routes.routes[1].length_m);
}

TEST(RoutesTest, ReturnsNoRouteIfThereIsNoWay) {
  ASSERT_OK_AND_ASSIGN(const Routes routes, FindRoutes(Graph({"r1", "r2"}, {}), FromR1ToR2(), {.max_routes = 3}));
  EXPECT_THAT(routes.routes, IsEmpty());
}

TEST(RoutesTest, WithinOneMapThereIsOneLeg) {
  RouteRequest request = FromR1ToR2();
  request.to_map = request.from_map;
  ASSERT_OK_AND_ASSIGN(const Routes routes, FindRoutes(Corridor(), request, {.max_routes = 3}));
  ASSERT_THAT(routes.routes, SizeIs(1));
  EXPECT_THAT(routes.routes[0].legs, SizeIs(1));
  EXPECT_DOUBLE_EQ(routes.routes[0].length_m, 2.0);
}

TEST(RoutesTest, ALiftLeadsToEachOfItsFloors) {
  LinkPoint lift = Joining("lift", {AnchorIn("f0", {5, 0, 0}), AnchorIn("f1", {1, 1, 0}), AnchorIn("f2", {0, 7, 0}),
                                    AnchorIn("f3", {2, 2, 0})});
  lift.kind = LinkPointKind::kLift;
  const GraphSnapshot graph = Graph({"f0", "f1", "f2", "f3"},
                                    {lift, Joining("stairs", {AnchorIn("f1", {9, 0, 0}), AnchorIn("f2", {9, 0, 0})})});
  ASSERT_OK_AND_ASSIGN(
      const Routes routes,
      FindRoutes(graph, {.from_map = M("f0"), .T_from_map_start = {}, .to_map = M("f2"), .T_to_map_goal = {1, 7, 0}},
                 {.max_routes = 4}));
  ASSERT_THAT(routes.routes, SizeIs(2));
  EXPECT_THAT(routes.routes[0].legs, SizeIs(2));
  EXPECT_DOUBLE_EQ(routes.routes[0].length_m, 6.0);
  // Out at f1, and by the stairs.
  ASSERT_THAT(routes.routes[1].legs, SizeIs(3));
  EXPECT_EQ(routes.routes[1].legs[1].exit, L("stairs"));
}

TEST(RoutesTest, RefusesInvalidRequests) {
  EXPECT_CODE(FindRoutes(Corridor(), FromR1ToR2(), {.max_routes = 0}), absl::StatusCode::kInvalidArgument);
  RouteRequest request = FromR1ToR2();
  request.T_to_map_goal.x = std::nan("");
  EXPECT_CODE(FindRoutes(Corridor(), request, {}), absl::StatusCode::kInvalidArgument);
  request = FromR1ToR2();
  request.to_map = M("nowhere");
  EXPECT_CODE(FindRoutes(Corridor(), request, {}), absl::StatusCode::kNotFound);
}

// All paths that repeat neither a map nor a link point, by exhaustion.
std::vector<double> AllCosts(const GraphSnapshot& graph, const PathSource& source, const PathTarget& target,
                             const PathOptions& options) {
  std::vector<double> costs;
  Path path;
  std::set<int> maps;
  std::set<int> links;
  const std::function<void(int)> visit = [&](int map) {
    path.maps.push_back(map);
    maps.insert(map);
    if (map == target.map) {
      costs.push_back(CostOf(graph, source, path, target, options));
    } else {
      for (const GraphSnapshot::Doorway& doorway : graph.map_node(map).doorways) {
        if (links.contains(doorway.link_point)) continue;
        path.link_points.push_back(doorway.link_point);
        links.insert(doorway.link_point);
        for (const int next : graph.link_point_node(doorway.link_point).maps) {
          if (!maps.contains(next)) visit(next);
        }
        path.link_points.pop_back();
        links.erase(doorway.link_point);
      }
    }
    path.maps.pop_back();
    maps.erase(map);
  };
  visit(source.map);
  std::sort(costs.begin(), costs.end());
  return costs;
}

TEST(RoutesTest, TheKShortestAreThoseOfExhaustion) {
  std::mt19937_64 random(17);
  std::size_t compared = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const testing::World world = testing::RandomWorld(7, 40.0, random);
    std::vector<LinkPoint> doors;
    for (int i = 0; i < 11; ++i) {
      const int a = static_cast<int>(random() % 7);
      std::vector<int> maps = {a, (a + 1 + static_cast<int>(random() % 6)) % 7};
      if (i % 4 == 0) {
        for (int m = 0; m < 7 && maps.size() < 3; ++m) {
          if (m != maps[0] && m != maps[1]) maps.push_back(m);
        }
      }
      // Exact: the straight way within a map is then never longer than one through others.
      const Pose2 place{Uniform(0, 40, random), Uniform(0, 40, random), Uniform(-3, 3, random)};
      std::vector<Anchor> anchors;
      for (const int m : maps) {
        anchors.push_back(AnchorIn(Numbered("m", m), Between(world.T_world_maps[static_cast<std::size_t>(m)], place)));
      }
      doors.push_back(Joining(Numbered("l", i), anchors));
    }
    const GraphSnapshot graph = Graph(world.MapIds(), doors);
    const PathSource source{.map = graph.MapSlot(M("m0")), .cost = 0.0, .position = Eigen::Vector2d(1, 1)};
    const PathTarget target{.map = graph.MapSlot(M("m6")), .position = Eigen::Vector2d(2, 0)};
    const PathOptions options{.cost = PathCost::kDistance};
    std::vector<double> all = AllCosts(graph, source, target, options);
    const std::vector<Path> found = KShortestPaths(graph, source, target, options, 12);
    ASSERT_EQ(found.size(), std::min<std::size_t>(all.size(), 12)) << trial;
    for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i].cost, all[i], 1e-9) << trial << ", " << i;
    compared += found.size();
  }
  EXPECT_GT(compared, 300u);
}

}  // namespace
}  // namespace enfilade::graph
