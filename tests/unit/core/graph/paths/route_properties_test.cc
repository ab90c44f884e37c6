// SPDX-License-Identifier: Apache-2.0
// Routes through random sites with exact anchors, and their GeoJSON.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "core/graph/geojson.h"
#include "core/graph/paths/routes.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/graph/scene.h"

namespace enfilade::graph {
namespace {

using nlohmann::json;
using testing::AnchorIn;
using testing::Graph;
using testing::Joining;
using testing::M;
using testing::Numbered;
using testing::Uniform;

struct ExactSite {
  testing::World world;
  GraphSnapshot graph;
};

// Some doors are blocked until time 1000.
ExactSite RandomSite(std::mt19937_64& random) {
  ExactSite site{testing::RandomWorld(8, 40.0, random), {}};
  std::vector<LinkPoint> links;
  for (int i = 0; i < 14; ++i) {
    const Pose2 place{Uniform(0, 40, random), Uniform(0, 40, random), Uniform(-3, 3, random)};
    const int a = static_cast<int>(random() % 8);
    std::vector<Anchor> anchors;
    for (const int map : {a, (a + 1 + static_cast<int>(random() % 7)) % 8}) {
      anchors.push_back(
          AnchorIn(Numbered("m", map), Between(site.world.T_world_maps[static_cast<std::size_t>(map)], place)));
    }
    links.push_back(Joining(Numbered("l", i), anchors));
    if (i % 4 == 0) {
      links.back().state = PassageState::kBlocked;
      links.back().state_valid_until = 1000;
    }
  }
  site.graph = Graph(site.world.MapIds(), links);
  return site;
}

class RouteSeeds : public ::testing::TestWithParam<unsigned> {
 protected:
  RouteSeeds() : random_(GetParam()), site_(RandomSite(random_)) {}

  RouteRequest Request(int to) {
    return {.from_map = M("m0"),
            .T_from_map_start = {Uniform(-5, 5, random_), Uniform(-5, 5, random_), 0.3},
            .to_map = M(Numbered("m", to)),
            .T_to_map_goal = {Uniform(-5, 5, random_), Uniform(-5, 5, random_), -1.0}};
  }
  Eigen::Vector2d InWorld(const MapId& map, const Pose2& T_map_place) const {
    const auto index = static_cast<std::size_t>(std::stoi(map.value().substr(1)));
    return (site_.world.T_world_maps[index] * T_map_place).translation();
  }

  std::mt19937_64 random_;
  ExactSite site_;
};
INSTANTIATE_TEST_SUITE_P(Sites, RouteSeeds, ::testing::Range(1U, 21U));

TEST_P(RouteSeeds, LegsAreContinuousFromStartToGoal) {
  for (int to = 1; to < 8; ++to) {
    const RouteRequest request = Request(to);
    ASSERT_OK_AND_ASSIGN(const Routes routes, FindRoutes(site_.graph, request, {.time = 2000, .max_routes = 4}));
    double last = 0.0;
    for (const Route& route : routes.routes) {
      EXPECT_GE(route.cost, last - 1e-9) << "best first";
      last = route.cost;
      ASSERT_FALSE(route.legs.empty());
      EXPECT_EQ(route.legs.front().map, request.from_map);
      EXPECT_EQ(route.legs.front().T_map_begin, request.T_from_map_start);
      EXPECT_EQ(route.legs.back().map, request.to_map);
      EXPECT_EQ(route.legs.back().T_map_end, request.T_to_map_goal);
      EXPECT_TRUE(route.legs.back().exit.empty());
      double length = 0.0;
      std::set<std::string> maps;
      for (std::size_t i = 0; i < route.legs.size(); ++i) {
        const RouteLeg& leg = route.legs[i];
        EXPECT_TRUE(maps.insert(leg.map.value()).second) << "a map twice";
        length += (leg.T_map_end.translation() - leg.T_map_begin.translation()).norm();
        if (i + 1 == route.legs.size()) continue;
        // In a world without errors a leg ends where the next one starts.
        const RouteLeg& next = route.legs[i + 1];
        EXPECT_LT((InWorld(leg.map, leg.T_map_end) - InWorld(next.map, next.T_map_begin)).norm(), 1e-9);
        EXPECT_NE(site_.graph.FindLinkPoint(leg.exit)->FindAnchor(next.map), nullptr);
      }
      EXPECT_NEAR(route.length_m, length, 1e-9);
      EXPECT_NEAR(route.cost, length, 1e-9);
      const double straight =
          (InWorld(request.to_map, request.T_to_map_goal) - InWorld(request.from_map, request.T_from_map_start)).norm();
      EXPECT_GE(route.length_m, straight - 1e-9);
    }
  }
}

TEST_P(RouteSeeds, BlockedDoorsAreAvoidedUntilTheyOpen) {
  for (int to = 1; to < 8; ++to) {
    const RouteRequest request = Request(to);
    ASSERT_OK_AND_ASSIGN(const Routes early, FindRoutes(site_.graph, request, {.time = 999}));
    ASSERT_OK_AND_ASSIGN(const Routes late, FindRoutes(site_.graph, request, {.time = 1000}));
    EXPECT_LE(early.routes.size(), late.routes.size());
    for (const Route& route : early.routes) {
      for (const RouteLeg& leg : route.legs) {
        if (!leg.exit.empty()) {
          EXPECT_EQ(site_.graph.FindLinkPoint(leg.exit)->state, PassageState::kOpen);
        }
      }
    }
    if (!early.routes.empty()) {
      EXPECT_LE(late.routes[0].cost, early.routes[0].cost + 1e-9);
    }
  }
}

TEST_P(RouteSeeds, GeoJsonHoldsEveryMapLinkPointAndEdge) {
  const json collection = json::parse(GraphToGeoJson(WorldPoses(site_.graph)));
  std::set<std::string> ids;
  for (const json& feature : collection["features"]) {
    EXPECT_EQ(feature["type"], "Feature");
    EXPECT_TRUE(ids.insert(feature["id"]).second) << feature["id"];
    if (feature["geometry"].is_null()) continue;
    if (feature["properties"]["kind"] == "edge") {
      const json& ends = feature["geometry"]["coordinates"];
      const Eigen::Vector2d a(ends[0][0], ends[0][1]);
      const Eigen::Vector2d b(ends[1][0], ends[1][1]);
      EXPECT_NEAR((b - a).norm(), feature["properties"]["length_m"].get<double>(), 1e-9);
    }
  }
  std::size_t edges = 0;
  for (const MapInGraph* map : site_.graph.ListMaps()) {
    EXPECT_TRUE(ids.contains("maps/" + map->id.value()));
    const std::size_t doorways = site_.graph.map_node(site_.graph.MapSlot(map->id)).doorways.size();
    edges += doorways * (doorways - (doorways > 0 ? 1 : 0)) / 2;
  }
  EXPECT_EQ(ids.size(), 8 + 14 + edges);
}

TEST_P(RouteSeeds, GeoreferencedPositionsAreThoseOfTheWorld) {
  const geo::TransverseMercator ground({.longitude = 13.4, .latitude = 52.5});
  std::vector<geo::SurveyPoint> points;
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(0, 0), Eigen::Vector2d(40, 0), Eigen::Vector2d(0, 40)}) {
    points.push_back({.place = ground.Inverse(p), .p_world = p});
  }
  ASSERT_OK_AND_ASSIGN(const geo::GeoreferenceFit fit, geo::FitGeoreference(points));
  const json metres = json::parse(GraphToGeoJson(WorldPoses(site_.graph)));
  const json degrees = json::parse(GraphToGeoJson(WorldPoses(site_.graph), &fit.georeference));
  ASSERT_EQ(metres["features"].size(), degrees["features"].size());
  int compared = 0;
  for (std::size_t i = 0; i < metres["features"].size(); ++i) {
    const json& geometry = metres["features"][i]["geometry"];
    EXPECT_EQ(geometry.is_null(), degrees["features"][i]["geometry"].is_null());
    if (geometry.is_null() || geometry["type"] != "Point") continue;
    const json& place = degrees["features"][i]["geometry"]["coordinates"];
    const Eigen::Vector2d p(geometry["coordinates"][0], geometry["coordinates"][1]);
    EXPECT_LT((ground.Forward({.longitude = place[0], .latitude = place[1]}) - p).norm(), 1e-3);
    ++compared;
  }
  EXPECT_GT(compared, 0);
}

}  // namespace
}  // namespace enfilade::graph
