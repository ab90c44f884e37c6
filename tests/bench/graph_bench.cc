// SPDX-License-Identifier: Apache-2.0
// The topological graph: shortest paths beside a plain Boost.Graph Dijkstra on the same graphs in the same run, answers
// after a change, optimisation. Rooms in a square grid, a door to each neighbour: link points are the vertices, two in
// the same room are joined.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <boost/graph/dijkstra_shortest_paths.hpp>
#include <cmath>
#include <map>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "core/graph/global_pose.h"
#include "core/graph/graph_optimization.h"
#include "core/graph/graph_snapshot.h"
#include "core/graph/paths/routes.h"
#include "core/graph/plans/plan_ties.h"
#include "fmt/format.h"

namespace enfilade::bench {
namespace {

constexpr double kRoom = 10.0;  // m

std::string RoomId(int x, int y) { return fmt::format("room-{}-{}", x, y); }

graph::LinkPoint Door(int x, int y, bool east, std::mt19937_64& random) {
  std::uniform_real_distribution<double> along(1.0, kRoom - 1.0);
  const double at = along(random);
  const auto anchor = [](const std::string& map, double px, double py) {
    return graph::Anchor{
        .map = MapId(map), .T_map_place = {px, py, 0.0}, .covariance = graph::DefaultAnchorCovariance()};
  };
  graph::LinkPoint door{.id = LinkPointId(fmt::format("door-{}-{}-{}", x, y, east ? "e" : "n"))};
  if (east) {
    door.anchors = {anchor(RoomId(x, y), kRoom, at), anchor(RoomId(x + 1, y), 0.0, at)};
  } else {
    door.anchors = {anchor(RoomId(x, y), at, kRoom), anchor(RoomId(x, y + 1), at, 0.0)};
  }
  return door;
}

// With about that many link points: 2 n (n - 1) for n x n rooms.
const graph::GraphSnapshot& Rooms(std::int64_t link_points) {
  static std::map<std::int64_t, graph::GraphSnapshot> graphs;
  const auto [found, is_new] = graphs.try_emplace(link_points);
  if (!is_new) return found->second;
  std::mt19937_64 random(1);
  const int n = static_cast<int>(std::lround(0.5 + std::sqrt(0.25 + 0.5 * static_cast<double>(link_points))));
  graph::SnapshotChanges changes{.version = 1};
  for (int x = 0; x < n; ++x) {
    for (int y = 0; y < n; ++y) {
      changes.maps.push_back({.id = MapId(RoomId(x, y))});
      if (x + 1 < n) changes.link_points.push_back(Door(x, y, true, random));
      if (y + 1 < n) changes.link_points.push_back(Door(x, y, false, random));
    }
  }
  found->second = graph::Apply({}, changes).value();
  return found->second;
}

graph::PathOptions ByDistance() { return {.cost = graph::PathCost::kDistance}; }

// From the first room to all link points.
void OurDijkstra(benchmark::State& state) {
  const graph::GraphSnapshot& graph = Rooms(state.range(0));
  const std::vector<graph::PathSource> sources = {
      {.map = graph.MapSlot(graph.root()), .cost = 0.0, .position = Eigen::Vector2d(0, 0)}};
  for (auto _ : state) benchmark::DoNotOptimize(graph::ShortestPaths(graph, sources, ByDistance()));
  state.counters["vertices"] = static_cast<double>(graph.link_point_count());
}

// The same edges and weights as ours; the source is a vertex of its own.
struct EdgeWeight {
  double weight = 0.0;
};
using BoostGraph = boost::compressed_sparse_row_graph<boost::directedS, boost::no_property, EdgeWeight>;

BoostGraph ToBoost(const graph::GraphSnapshot& graph) {
  std::vector<std::pair<std::size_t, std::size_t>> edges;
  std::vector<EdgeWeight> weights;
  const std::size_t source = graph.link_point_slots();
  for (std::size_t m = 0; m < graph.map_slots(); ++m) {
    const graph::GraphSnapshot::MapNode& map = graph.map_node(static_cast<int>(m));
    for (const auto& a : map.doorways) {
      for (const auto& b : map.doorways) {
        if (a.link_point == b.link_point) continue;
        edges.emplace_back(a.link_point, b.link_point);
        weights.push_back({std::hypot(a.x - b.x, a.y - b.y)});
      }
      if (map.map->id != graph.root()) continue;
      edges.emplace_back(source, a.link_point);
      weights.push_back({std::hypot(a.x, a.y)});
    }
  }
  return {boost::edges_are_unsorted_multi_pass, edges.begin(), edges.end(), weights.begin(), source + 1};
}

void BoostDijkstra(benchmark::State& state) {
  const graph::GraphSnapshot& graph = Rooms(state.range(0));
  const BoostGraph boost_graph = ToBoost(graph);
  const std::size_t source = graph.link_point_slots();
  std::vector<double> distance(source + 1);
  std::vector<std::size_t> predecessor(source + 1);
  for (auto _ : state) {
    boost::dijkstra_shortest_paths(
        boost_graph, source,
        boost::weight_map(boost::get(&EdgeWeight::weight, boost_graph))
            .distance_map(boost::make_iterator_property_map(distance.begin(), get(boost::vertex_index, boost_graph)))
            .predecessor_map(
                boost::make_iterator_property_map(predecessor.begin(), get(boost::vertex_index, boost_graph))));
    benchmark::DoNotOptimize(distance.data());
  }
  const std::vector<graph::PathSource> sources = {
      {.map = graph.MapSlot(graph.root()), .cost = 0.0, .position = Eigen::Vector2d(0, 0)}};
  const std::vector<graph::PathLabel> ours = graph::ShortestPaths(graph, sources, ByDistance());
  double difference = 0.0;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    // Boost also allows to turn round at a link point into the room that it came from, which never is shorter.
    difference = std::max(difference, std::abs(ours[i].cost - distance[i]));
  }
  state.counters["difference_m"] = difference;
  state.counters["edges"] = static_cast<double>(boost::num_edges(boost_graph));
}

BENCHMARK(OurDijkstra)->Arg(10'000)->Arg(90'000)->Arg(100'000)->Arg(1'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK(BoostDijkstra)->Arg(10'000)->Arg(90'000)->Arg(100'000)->Arg(1'000'000)->Unit(benchmark::kMillisecond);

// Corner to corner, ending where the goal is reached.
void RouteAcross(benchmark::State& state) {
  const graph::GraphSnapshot& graph = Rooms(state.range(0));
  const int n = static_cast<int>(std::lround(std::sqrt(static_cast<double>(graph.map_count()))));
  const graph::RouteRequest request{.from_map = MapId(RoomId(0, 0)),
                                    .T_from_map_start = {1, 1, 0},
                                    .to_map = MapId(RoomId(n - 1, n - 1)),
                                    .T_to_map_goal = {9, 9, 0}};
  for (auto _ : state) {
    benchmark::DoNotOptimize(graph::FindRoutes(graph, request, {.max_routes = static_cast<int>(state.range(1))}));
  }
}
BENCHMARK(RouteAcross)->Args({10'000, 1})->Args({1'000, 3})->Unit(benchmark::kMillisecond);

// A graph of 10^4 maps: one link point changes, and a robot asks for its global pose.
void AnswerAfterAChange(benchmark::State& state) {
  graph::GraphSnapshot graph = Rooms(20'000);
  const LinkPointId id("door-3-4-e");
  std::int64_t version = 1;
  for (auto _ : state) {
    graph::LinkPoint door = *graph.FindLinkPoint(id);
    door.anchors[0].T_map_place.y += 0.01;
    graph = graph::Apply(graph, {.version = ++version, .link_points = {door}}).value();
    const graph::WorldPoses poses(graph);
    benchmark::DoNotOptimize(poses.Find(MapId(RoomId(50, 50)), {{1, 2, 3}, graph::DefaultTransformCovariance()}));
  }
  state.counters["maps"] = static_cast<double>(graph.map_count());
}
BENCHMARK(AnswerAfterAChange)->Unit(benchmark::kMillisecond);

// Of n x n rooms: the walls between and around them, whose corners are 0.05 m off; each room has seen its four walls.
graph::GraphSnapshot WithPlan(const graph::GraphSnapshot& rooms, int n) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0.0, 0.05);
  const auto ties = std::make_shared<graph::PlanTies>();
  const auto corner = [n](int x, int y) { return y * (n + 1) + x; };
  for (int y = 0; y <= n; ++y) {
    for (int x = 0; x <= n; ++x) ties->corners.emplace_back(kRoom * x + noise(random), kRoom * y + noise(random));
  }
  // Below and to the left of each corner.
  std::map<std::pair<int, int>, int> strut_of;
  const auto add = [&](int from, int to) {
    const int strut = static_cast<int>(ties->struts.size());
    strut_of[{from, to}] = strut;
    ties->struts.push_back({from, to, strut});
  };
  for (int y = 0; y <= n; ++y) {
    for (int x = 0; x <= n; ++x) {
      if (x < n) add(corner(x, y), corner(x + 1, y));
      if (y < n) add(corner(x, y), corner(x, y + 1));
    }
  }
  for (int x = 0; x < n; ++x) {
    for (int y = 0; y < n; ++y) {
      const MapId map(RoomId(x, y));
      ties->maps.push_back({map, {kRoom * x, kRoom * y, 0.0}});
      const auto see = [&](int from, int to, const Pose2& T_map_line) {
        ties->sightings.push_back({.strut = strut_of.at({from, to}),
                                   .map = map,
                                   .T_map_line = T_map_line,
                                   .length = kRoom,
                                   .across_sigma = 0.05,
                                   .yaw_sigma = 0.01});
      };
      see(corner(x, y), corner(x + 1, y), {0.5 * kRoom, 0.0, 0.0});
      see(corner(x, y + 1), corner(x + 1, y + 1), {0.5 * kRoom, kRoom, 0.0});
      see(corner(x, y), corner(x, y + 1), {0.0, 0.5 * kRoom, 0.5 * M_PI});
      see(corner(x + 1, y), corner(x + 1, y + 1), {kRoom, 0.5 * kRoom, 0.5 * M_PI});
    }
  }
  std::sort(ties->maps.begin(), ties->maps.end(), [](const auto& a, const auto& b) { return a.map < b.map; });
  return graph::Apply(rooms, {.version = rooms.version() + 1,
                              .plans = std::vector<graph::PlanInGraph>{{PriorMapId("plan"), "", ties}}})
      .value();
}

// 22 x 22 rooms with 924 doors, and the 1,012 walls of their plan.
void OptimizeRooms(benchmark::State& state) {
  const graph::GraphSnapshot& rooms = Rooms(924);
  const graph::GraphSnapshot graph = state.range(0) == 0 ? rooms : WithPlan(rooms, 22);
  for (auto _ : state) benchmark::DoNotOptimize(graph::OptimizeGraph(graph));
  const auto solved = graph::OptimizeGraph(graph);
  state.counters["maps"] = static_cast<double>(solved.value().map_poses.size());
  for (const graph::PlanUse& plan : solved->plans) state.counters["walls_used"] = plan.used;
}
BENCHMARK(OptimizeRooms)->ArgName("with_plan")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

void ApplyOneChange(benchmark::State& state) {
  graph::GraphSnapshot graph = Rooms(state.range(0));
  const graph::LinkPoint door = *graph.FindLinkPoint(LinkPointId("door-3-4-e"));
  for (auto _ : state) {
    graph = graph::Apply(graph, {.version = graph.version() + 1, .link_points = {door}}).value();
  }
}
BENCHMARK(ApplyOneChange)->Arg(20'000)->Arg(1'000'000)->Unit(benchmark::kMicrosecond);

void FindGlobalPose(benchmark::State& state) {
  const graph::WorldPoses poses(Rooms(20'000));
  const PoseWithCovariance T_map_robot{{1, 2, 3}, graph::DefaultTransformCovariance()};
  const MapId map(RoomId(static_cast<int>(state.range(0)), static_cast<int>(state.range(0))));
  for (auto _ : state) benchmark::DoNotOptimize(poses.Find(map, T_map_robot));
}
BENCHMARK(FindGlobalPose)->Arg(1)->Arg(5)->Arg(50)->Unit(benchmark::kMicrosecond);

void Optimize(benchmark::State& state) {
  const graph::GraphSnapshot& graph = Rooms(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(graph::OptimizeGraph(graph));
  state.counters["maps"] = static_cast<double>(graph.map_count());
}
BENCHMARK(Optimize)->Arg(200)->Arg(2'000)->Arg(20'000)->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
}  // namespace enfilade::bench

BENCHMARK_MAIN();
