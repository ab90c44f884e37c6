// SPDX-License-Identifier: Apache-2.0
#include "core/graph/geojson.h"

#include <gmock/gmock.h>

#include "nlohmann/json.hpp"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/graph/scene.h"

namespace enfilade::graph {
namespace {

using nlohmann::json;
using testing::AnchorIn;
using testing::Graph;
using testing::Joining;
using testing::M;

GraphSnapshot TwoRooms() {
  SnapshotChanges changes{.version = 5};
  changes.maps = {{.id = M("a"),
                   .display_name = "A \"quoted\" \\ name",
                   .level = 2,
                   .outline = {{0, 0}, {0, 4}, {6, 4}, {6, 0}}},  // clockwise
                  {.id = M("b"), .display_name = "B"},
                  {.id = M("far"), .display_name = "Far"}};
  LinkPoint x = Joining("x", {AnchorIn("a", {6, 1, 0}), AnchorIn("b", {0, 0, 0})});
  x.tag = "tag\xff/'";
  changes.link_points = {x, Joining("y", {AnchorIn("a", {6, 3, 0}), AnchorIn("b", {0, 2, 0})}),
                         Joining("c", {AnchorIn("far", {1, 1, 0})})};
  return Apply(GraphSnapshot(), changes).value();
}

json FeatureOf(const json& collection, const std::string& id) {
  for (const json& feature : collection["features"]) {
    if (feature["id"] == id) return feature;
  }
  return nullptr;
}

TEST(GeoJsonTest, WritesMapsLinkPointsAndEdges) {
  const json graph = json::parse(GraphToGeoJson(WorldPoses(TwoRooms())));
  EXPECT_EQ(graph["type"], "FeatureCollection");
  EXPECT_EQ(graph["graph_version"], 5);
  EXPECT_EQ(graph["frame"], "world_metres");
  const json a = FeatureOf(graph, "maps/a");
  EXPECT_EQ(a["properties"]["display_name"], "A \"quoted\" \\ name");
  // Closed and counter-clockwise.
  EXPECT_EQ(a["geometry"]["coordinates"], json::parse("[[[0,0],[6,0],[6,4],[0,4],[0,0]]]"));
  EXPECT_EQ(FeatureOf(graph, "maps/b")["geometry"]["coordinates"], json::parse("[6,1]"));
  EXPECT_EQ(FeatureOf(graph, "linkPoints/x")["properties"]["maps"], json::parse("[\"a\",\"b\"]"));
  EXPECT_EQ(FeatureOf(graph, "maps/a/edges/x/y")["geometry"]["coordinates"], json::parse("[[6,1],[6,3]]"));
  EXPECT_EQ(FeatureOf(graph, "maps/b/edges/x/y")["properties"]["length_m"], 2.0);
}

TEST(GeoJsonTest, WritesTracks) {
  const std::vector<Track> tracks = {{SessionId("s"), RobotId("r"), M("b"), {{0, 0}, {1, 2}}},
                                     {SessionId("far"), RobotId("r"), M("far"), {{0, 0}, {1, 2}}}};
  const json graph = json::parse(GraphToGeoJson(WorldPoses(TwoRooms()), nullptr, false, tracks));
  const json track = FeatureOf(graph, "sessions/s/track");
  EXPECT_EQ(track["geometry"], json::parse(R"({"type":"LineString","coordinates":[[6,1],[7,3]]})"));
  EXPECT_EQ(track["properties"], json::parse(R"({"kind":"track","session":"s","robot":"r","map":"b"})"));
  EXPECT_TRUE(FeatureOf(graph, "sessions/far/track")["geometry"].is_null());
}

TEST(GeoJsonTest, DisconnectedFeaturesHaveNoGeometry) {
  const json graph = json::parse(GraphToGeoJson(WorldPoses(TwoRooms())));
  EXPECT_TRUE(FeatureOf(graph, "maps/far")["geometry"].is_null());
  const json candidate = FeatureOf(graph, "linkPoints/c");
  EXPECT_TRUE(candidate["geometry"].is_null());
  EXPECT_EQ(candidate["properties"]["kind"], "link_point_candidate");
}

TEST(GeoJsonTest, IsInLongitudeAndLatitudeWithAGeoreference) {
  const std::vector<geo::SurveyPoint> points = {{.place = {9.7000, 52.3700}, .p_world = {0, 0}},
                                                {.place = {9.7020, 52.3700}, .p_world = {136.2, 0}}};
  ASSERT_OK_AND_ASSIGN(const geo::GeoreferenceFit fit, geo::FitGeoreference(points));
  const json graph = json::parse(GraphToGeoJson(WorldPoses(TwoRooms()), &fit.georeference));
  EXPECT_FALSE(graph.contains("frame"));
  const json at = FeatureOf(graph, "linkPoints/x")["geometry"]["coordinates"];
  const geo::LonLat expected = fit.georeference.ToLonLat({6, 1});
  EXPECT_NEAR(at[0], expected.longitude, 1e-9);
  EXPECT_NEAR(at[1], expected.latitude, 1e-9);
}

TEST(GeoJsonTest, WritesRoutesLegByLeg) {
  const WorldPoses poses(TwoRooms());
  ASSERT_OK_AND_ASSIGN(
      const Routes routes,
      FindRoutes(poses.graph(),
                 {.from_map = M("a"), .T_from_map_start = {1, 1, 0}, .to_map = M("b"), .T_to_map_goal = {2, 0, 0}},
                 {.max_routes = 2}));
  const json collection = json::parse(RoutesToGeoJson(routes, poses));
  EXPECT_EQ(collection["features"].size(), 4u);
  const json leg = FeatureOf(collection, "routes/0/legs/1");
  EXPECT_EQ(leg["geometry"]["coordinates"], json::parse("[[6,1],[8,1]]"));
  EXPECT_EQ(leg["properties"]["map"], "b");
  EXPECT_EQ(FeatureOf(collection, "routes/0/legs/0")["properties"]["exit"], "x");
}

}  // namespace
}  // namespace enfilade::graph
