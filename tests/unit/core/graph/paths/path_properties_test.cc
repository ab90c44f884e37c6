// SPDX-License-Identifier: Apache-2.0
// Searches on random graphs against exhaustive ones, and properties that hold for any graph.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <set>

#include "core/graph/global_pose.h"
#include "core/graph/paths/k_shortest_paths.h"
#include "core/graph/paths/pose_chain.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/graph/scene.h"

namespace enfilade::graph {
namespace {

using testing::AnchorIn;
using testing::Graph;
using testing::Joining;
using testing::M;
using testing::Numbered;
using testing::PoseNear;
using testing::RandomCovariance;
using testing::Uniform;

constexpr double kUnreachable = std::numeric_limits<double>::infinity();

// Doors between two maps and lifts between three, with noisy anchors; `maps` of them may stay alone.
std::vector<LinkPoint> RandomLinks(const testing::World& world, int count, std::mt19937_64& random) {
  const auto maps = static_cast<int>(world.T_world_maps.size());
  std::vector<LinkPoint> links;
  for (int i = 0; i < count; ++i) {
    std::set<int> joined;
    while (joined.size() < (i % 4 == 0 ? 3U : 2U))
      joined.insert(static_cast<int>(random() % static_cast<unsigned>(maps)));
    std::vector<Eigen::Matrix3d> covariances;
    for (std::size_t k = 0; k < joined.size(); ++k) covariances.push_back(RandomCovariance(0.03, 0.005, random));
    links.push_back(world.See(Numbered("l", i),
                              {Uniform(0, 50, random), Uniform(0, 50, random), Uniform(-3, 3, random)},
                              {joined.begin(), joined.end()}, covariances, random));
  }
  return links;
}

// All pairs of maps by Floyd and Warshall, with fixed lever: the cost of passing from one map into another by one link
// point is that of its two anchors, or 1.
std::vector<std::vector<double>> AllPairs(const std::vector<LinkPoint>& links, int maps, PathCost cost) {
  const auto n = static_cast<std::size_t>(maps);
  std::vector<std::vector<double>> best(n, std::vector<double>(n, kUnreachable));
  for (std::size_t i = 0; i < n; ++i) best[i][i] = 0.0;
  const auto index = [](const Anchor& anchor) {
    return static_cast<std::size_t>(std::stoi(anchor.map.value().substr(1)));
  };
  for (const LinkPoint& link : links) {
    for (const Anchor& a : link.anchors) {
      for (const Anchor& b : link.anchors) {
        if (a.map == b.map) continue;
        const double step =
            cost == PathCost::kHops ? 1.0 : UncertaintyOf(a.covariance, 100.0) + UncertaintyOf(b.covariance, 100.0);
        best[index(a)][index(b)] = std::min(best[index(a)][index(b)], step);
      }
    }
  }
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) best[i][j] = std::min(best[i][j], best[i][k] + best[k][j]);
    }
  }
  return best;
}

class PathSeeds : public ::testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Graphs, PathSeeds, ::testing::Range(1U, 16U));

TEST_P(PathSeeds, CostsAreThoseOfFloydAndWarshall) {
  std::mt19937_64 random(GetParam());
  const testing::World world = testing::RandomWorld(10, 50.0, random);
  const std::vector<LinkPoint> links = RandomLinks(world, 9, random);
  const GraphSnapshot graph = Graph(world.MapIds(), links);
  for (const PathCost cost : {PathCost::kHops, PathCost::kUncertainty}) {
    const auto expected = AllPairs(links, 10, cost);
    for (int a = 0; a < 10; ++a) {
      for (int b = 0; b < 10; ++b) {
        const double best = expected[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)];
        const std::optional<Path> path = ShortestPath(graph, {{.map = graph.MapSlot(M(Numbered("m", a)))}},
                                                      {.map = graph.MapSlot(M(Numbered("m", b)))}, {.cost = cost});
        ASSERT_EQ(path.has_value(), std::isfinite(best)) << a << " to " << b;
        if (path) {
          EXPECT_NEAR(path->cost, best, 1e-9) << a << " to " << b;
        }
      }
    }
  }
}

TEST_P(PathSeeds, SeveralSourcesGiveTheBestOfThem) {
  std::mt19937_64 random(GetParam() + 100);
  const testing::World world = testing::RandomWorld(10, 50.0, random);
  const GraphSnapshot graph = Graph(world.MapIds(), RandomLinks(world, 10, random));
  std::vector<PathSource> sources;
  for (const int map : {0, 3, 7}) {
    sources.push_back({.map = graph.MapSlot(M(Numbered("m", map)))});
  }
  for (int b = 0; b < 10; ++b) {
    const PathTarget target{.map = graph.MapSlot(M(Numbered("m", b)))};
    if (std::any_of(sources.begin(), sources.end(), [&](const PathSource& s) { return s.map == target.map; })) continue;
    double best = kUnreachable;
    for (const PathSource& source : sources) {
      if (const auto path = ShortestPath(graph, {source}, target, {})) best = std::min(best, path->cost);
    }
    const auto together = ShortestPath(graph, sources, target, {});
    ASSERT_EQ(together.has_value(), std::isfinite(best));
    if (together) {
      EXPECT_NEAR(together->cost, best, 1e-12);
    }
  }
}

TEST_P(PathSeeds, PathsAreConsistentWithTheGraph) {
  std::mt19937_64 random(GetParam() + 200);
  const testing::World world = testing::RandomWorld(12, 50.0, random);
  const GraphSnapshot graph = Graph(world.MapIds(), RandomLinks(world, 16, random));
  for (const PathCost cost : {PathCost::kUncertainty, PathCost::kDistance, PathCost::kHops}) {
    const std::vector<PathSource> sources = {{.map = graph.MapSlot(M("m0")), .position = Eigen::Vector2d(1, 2)}};
    for (int b = 1; b < 12; ++b) {
      const PathTarget target{.map = graph.MapSlot(M(Numbered("m", b))), .position = Eigen::Vector2d(-1, 0)};
      const auto path = ShortestPath(graph, sources, target, {.cost = cost});
      if (!path) continue;
      ASSERT_EQ(path->maps.size(), path->link_points.size() + 1);
      EXPECT_EQ(path->maps.front(), sources[0].map);
      EXPECT_EQ(path->maps.back(), target.map);
      for (std::size_t i = 0; i < path->link_points.size(); ++i) {
        const LinkPoint& link = *graph.link_point_node(path->link_points[i]).link_point;
        EXPECT_NE(path->maps[i], path->maps[i + 1]);
        EXPECT_NE(link.FindAnchor(graph.map_node(path->maps[i]).map->id), nullptr);
        EXPECT_NE(link.FindAnchor(graph.map_node(path->maps[i + 1]).map->id), nullptr);
      }
      EXPECT_NEAR(CostOf(graph, sources[0], *path, target, {.cost = cost}), path->cost, 1e-9);
    }
  }
}

TEST_P(PathSeeds, ExcludedLinkPointsAndMapsAreAvoided) {
  std::mt19937_64 random(GetParam() + 300);
  const testing::World world = testing::RandomWorld(10, 50.0, random);
  const std::vector<LinkPoint> links = RandomLinks(world, 14, random);
  const GraphSnapshot graph = Graph(world.MapIds(), links);
  const std::unordered_set<int> without_links = {graph.LinkPointSlot(LinkPointId("l1")),
                                                 graph.LinkPointSlot(LinkPointId("l4"))};
  const std::unordered_set<int> without_maps = {graph.MapSlot(M("m5"))};
  const PathOptions options{.without_link_points = &without_links, .without_maps = &without_maps};
  // The same graph without them.
  std::vector<LinkPoint> rest;
  for (LinkPoint link : links) {
    if (link.id == LinkPointId("l1") || link.id == LinkPointId("l4")) continue;
    std::erase_if(link.anchors, [](const Anchor& anchor) { return anchor.map == M("m5"); });
    if (!link.anchors.empty()) rest.push_back(link);
  }
  const GraphSnapshot smaller = Graph(world.MapIds(), rest);
  for (int b = 1; b < 10; ++b) {
    if (b == 5) continue;
    const auto find = [&](const GraphSnapshot& in, const PathOptions& with) {
      return ShortestPath(in, {{.map = in.MapSlot(M("m0"))}}, {.map = in.MapSlot(M(Numbered("m", b)))}, with);
    };
    const auto excluded = find(graph, options);
    const auto expected = find(smaller, {});
    ASSERT_EQ(excluded.has_value(), expected.has_value()) << b;
    if (excluded) {
      EXPECT_NEAR(excluded->cost, expected->cost, 1e-12) << b;
    }
  }
}

// Simple paths by enumeration, with the cost of CostOf.
std::vector<double> EnumeratedCosts(const GraphSnapshot& graph, const PathSource& source, const PathTarget& target,
                                    const PathOptions& options) {
  std::vector<double> costs;
  Path path{.cost = 0.0, .source = 0, .maps = {source.map}, .link_points = {}};
  const std::function<void()> extend = [&] {
    if (path.maps.back() == target.map) {
      costs.push_back(CostOf(graph, source, path, target, options));
      return;
    }
    for (const GraphSnapshot::Doorway& doorway : graph.map_node(path.maps.back()).doorways) {
      if (std::count(path.link_points.begin(), path.link_points.end(), doorway.link_point) > 0) continue;
      for (const int next : graph.link_point_node(doorway.link_point).maps) {
        if (std::count(path.maps.begin(), path.maps.end(), next) > 0) continue;
        path.maps.push_back(next);
        path.link_points.push_back(doorway.link_point);
        extend();
        path.maps.pop_back();
        path.link_points.pop_back();
      }
    }
  };
  extend();
  std::sort(costs.begin(), costs.end());
  return costs;
}

TEST_P(PathSeeds, KShortestByHopsAndUncertaintyAreThoseOfEnumeration) {
  std::mt19937_64 random(GetParam() + 400);
  const testing::World world = testing::RandomWorld(6, 30.0, random);
  const GraphSnapshot graph = Graph(world.MapIds(), RandomLinks(world, 8, random));
  const PathSource source{.map = graph.MapSlot(M("m0"))};
  const PathTarget target{.map = graph.MapSlot(M("m4"))};
  for (const PathCost cost : {PathCost::kHops, PathCost::kUncertainty}) {
    const std::vector<double> all = EnumeratedCosts(graph, source, target, {.cost = cost});
    const std::vector<Path> found = KShortestPaths(graph, source, target, {.cost = cost}, 10);
    ASSERT_EQ(found.size(), std::min<std::size_t>(all.size(), 10));
    std::set<std::pair<std::vector<int>, std::vector<int>>> distinct;
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_NEAR(found[i].cost, all[i], 1e-12);
      distinct.insert({found[i].maps, found[i].link_points});
    }
    EXPECT_EQ(distinct.size(), found.size());
  }
}

TEST_P(PathSeeds, ResultsDoNotDependOnTheHistoryOfTheSnapshot) {
  std::mt19937_64 random(GetParam() + 500);
  const testing::World world = testing::RandomWorld(9, 50.0, random);
  std::vector<LinkPoint> links = RandomLinks(world, 12, random);
  const GraphSnapshot direct = Graph(world.MapIds(), links);
  // In another order, one by one, with detours through changes that are undone.
  std::vector<std::string> maps = world.MapIds();
  std::shuffle(maps.begin() + 1, maps.end(), random);
  std::shuffle(links.begin(), links.end(), random);
  GraphSnapshot grown = Graph({"m0"}, {});
  grown = Graph({maps.begin() + 1, maps.end()}, {}, grown);
  for (const LinkPoint& link : links) {
    LinkPoint wrong = link;
    wrong.anchors[0].T_map_place.x += 5.0;
    grown = Graph({}, {wrong}, grown);
    grown = Apply(grown, {.version = grown.version() + 1, .removed_link_points = {link.id}}).value();
    grown = Graph({}, {link}, grown);
  }
  const WorldPoses of_direct(direct);
  const WorldPoses of_grown(grown);
  for (const std::string& map : maps) {
    const auto a = of_direct.Find(M(map)).value();
    const auto b = of_grown.Find(M(map)).value();
    ASSERT_EQ(a.has_value(), b.has_value()) << map;
    if (!a) continue;
    EXPECT_EQ(a->T_world_robot.pose, b->T_world_robot.pose) << map;
    EXPECT_EQ(a->T_world_robot.covariance, b->T_world_robot.covariance) << map;
  }
}

TEST_P(PathSeeds, SharesAreTheNumericalJacobians) {
  std::mt19937_64 random(GetParam() + 600);
  const testing::World world = testing::RandomWorld(5, 20.0, random);
  std::vector<LinkPoint> row;
  for (int i = 0; i < 4; ++i) {
    row.push_back(world.See(Numbered("l", i), {Uniform(0, 20, random), Uniform(0, 20, random), Uniform(-3, 3, random)},
                            {i, i + 1}, {RandomCovariance(0.05, 0.01, random), RandomCovariance(0.05, 0.01, random)},
                            random));
  }
  const GraphSnapshot graph = Graph(world.MapIds(), row);
  const PoseWithCovariance start{{1, -2, 0.4}, RandomCovariance(0.1, 0.02, random)};
  const PoseWithCovariance end{{3, 1, -1.1}, RandomCovariance(0.1, 0.02, random)};
  const Path path = ShortestPath(graph, {{.map = graph.MapSlot(M("m0"))}}, {.map = graph.MapSlot(M("m4"))}, {}).value();
  const PoseChain chain = ChainAlong(graph, path, start, end);
  ASSERT_EQ(chain.hops.size(), 4U);
  // d result / d (parameters of hop i), by central differences.
  for (std::size_t i = 0; i < chain.hops.size(); ++i) {
    const auto result = [&](const Eigen::Vector3d& change) {
      Pose2 pose = start.pose;
      for (std::size_t k = 0; k < chain.hops.size(); ++k) {
        Pose2 hop = chain.hops[k].T_from_to.pose;
        if (k == i) hop = {hop.x + change.x(), hop.y + change.y(), hop.yaw + change.z()};
        pose = pose * hop;
      }
      return pose * end.pose;
    };
    Eigen::Matrix3d J;
    for (int k = 0; k < 3; ++k) {
      Eigen::Vector3d step = Eigen::Vector3d::Zero();
      step[k] = 1e-6;
      const Pose2 plus = result(step);
      const Pose2 minus = result(-step);
      J.col(k) << (plus.x - minus.x) / 2e-6, (plus.y - minus.y) / 2e-6, WrapAngle(plus.yaw - minus.yaw) / 2e-6;
    }
    EXPECT_TRUE(chain.hops[i].share.isApprox(J * chain.hops[i].T_from_to.covariance * J.transpose(), 1e-6)) << i;
  }
}

TEST_P(PathSeeds, TransformsComposeToTheIdentityAroundAnyPair) {
  std::mt19937_64 random(GetParam() + 700);
  const testing::World world = testing::RandomWorld(7, 40.0, random);
  const GraphSnapshot graph = Graph(world.MapIds(), RandomLinks(world, 10, random));
  for (int a = 0; a < 7; ++a) {
    for (int b = 0; b < 7; ++b) {
      ASSERT_OK_AND_ASSIGN(const auto there, FindTransform(graph, M(Numbered("m", a)), M(Numbered("m", b))));
      ASSERT_OK_AND_ASSIGN(const auto back, FindTransform(graph, M(Numbered("m", b)), M(Numbered("m", a))));
      ASSERT_EQ(there.has_value(), back.has_value());
      if (!there) continue;
      EXPECT_THAT(there->T_a_b.pose * back->T_a_b.pose, PoseNear(Pose2{}, 1e-9, 1e-9)) << a << ", " << b;
      EXPECT_EQ(there->hops.size(), back->hops.size());
      if (a == b) {
        EXPECT_TRUE(there->hops.empty() && there->T_a_b.covariance.isZero());
      }
    }
  }
}

}  // namespace
}  // namespace enfilade::graph
