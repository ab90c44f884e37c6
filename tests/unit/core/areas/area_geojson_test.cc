// SPDX-License-Identifier: Apache-2.0
#include "core/areas/area_geojson.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "nlohmann/json.hpp"
#include "tests/support/status_assertions.h"

namespace enfilade::areas {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

NamedArea Ramp() {
  NamedArea ramp{MapAreaId("ramp"), {}};
  ramp.area.kind = AreaKind::kSpeedLimit;
  ramp.area.display_name = "Ramp \"north\", Größe 2";
  ramp.area.outline = {{0.1, 0.2}, {1.0 / 3.0, 4}, {5, 6.0000000000000009}};
  ramp.area.robot_types = {"cleaner", "forklift"};
  ramp.area.speed_limit_mps = 0.3;
  ramp.area.valid_from = 1'767'225'600'000'000'000;   // 2026-01-01T00:00:00Z
  ramp.area.valid_until = 1'767'225'600'123'456'000;  // a fraction of a second later
  return ramp;
}

json FeatureWith(const json& properties, json ring = {{0, 0}, {1, 0}, {1, 1}, {0, 0}}) {
  json feature = {{"type", "Feature"}, {"properties", properties}};
  feature["geometry"] = {{"type", "Polygon"}, {"coordinates", json::array({std::move(ring)})}};
  return {{"type", "FeatureCollection"}, {"features", json::array({std::move(feature)})}};
}

void ExpectRefused(const json& document, const std::string& why) {
  EXPECT_STATUS(ReadAreasGeoJson(document.dump()), absl::StatusCode::kInvalidArgument, HasSubstr(why));
}

TEST(AreaGeoJson, IsWrittenAsTheRfcSays) {
  const json written = json::parse(WriteAreasGeoJson({Ramp()}));
  EXPECT_EQ(written["type"], "FeatureCollection");
  EXPECT_EQ(written["frame"], "map_metres");
  const json& feature = written["features"][0];
  EXPECT_EQ(feature["id"], "areas/ramp");
  EXPECT_EQ(feature["properties"]["kind"], "speed-limit");
  EXPECT_EQ(feature["properties"]["valid_from"], "2026-01-01T00:00:00+00:00");
  const json& ring = feature["geometry"]["coordinates"][0];
  ASSERT_EQ(ring.size(), 4U);
  EXPECT_EQ(ring[0], ring[3]);
  // Counter-clockwise: the triangle was given clockwise.
  EXPECT_EQ(ring[1], json::array({5.0, 6.0000000000000009}));
}

TEST(AreaGeoJson, ReadsBackExactly) {
  NamedArea room{MapAreaId("room"), {}};
  room.area.kind = AreaKind::kRoom;
  room.area.display_name = "Room";
  room.area.outline = {{0, 0}, {1e-3, 0}, {1e-3, 7}};
  ASSERT_OK_AND_ASSIGN(const auto read, ReadAreasGeoJson(WriteAreasGeoJson({Ramp(), room})));
  ASSERT_EQ(read.size(), 2U);
  const MapArea& ramp = read[0].area;
  EXPECT_EQ(read[0].id, MapAreaId("ramp"));
  EXPECT_EQ(ramp.kind, AreaKind::kSpeedLimit);
  EXPECT_EQ(ramp.display_name, Ramp().area.display_name);
  EXPECT_EQ(ramp.robot_types, Ramp().area.robot_types);
  EXPECT_EQ(ramp.speed_limit_mps, 0.3);
  EXPECT_EQ(ramp.valid_from, Ramp().area.valid_from);
  EXPECT_EQ(ramp.valid_until, Ramp().area.valid_until);
  ASSERT_EQ(ramp.outline.size(), 3U);
  EXPECT_EQ(ramp.outline[0], Ramp().area.outline[0]);
  EXPECT_EQ(ramp.outline[1], Ramp().area.outline[2]);
  EXPECT_EQ(ramp.outline[2], Ramp().area.outline[1]);
  EXPECT_EQ(read[1].area.outline, room.area.outline);
  EXPECT_FALSE(read[1].area.valid_from.has_value());
}

TEST(AreaGeoJson, ReadsThatOfOtherPrograms) {
  json document = FeatureWith({{"kind", "keep-out"}, {"colour", "red"}, {"name", nullptr}});
  document["features"][0]["id"] = 7;
  ASSERT_OK_AND_ASSIGN(const auto read, ReadAreasGeoJson(document.dump()));
  ASSERT_EQ(read.size(), 1U);
  EXPECT_TRUE(read[0].id.empty());
  EXPECT_EQ(read[0].area.display_name, "keep-out");
}

TEST(AreaGeoJson, NamesTheFeatureAndItsFault) {
  EXPECT_STATUS(ReadAreasGeoJson("{"), absl::StatusCode::kInvalidArgument, HasSubstr("not GeoJSON"));
  ExpectRefused(json::array(), "not a GeoJSON FeatureCollection");
  json other_frame = FeatureWith({{"kind", "room"}});
  other_frame["frame"] = "world_metres";
  ExpectRefused(other_frame, "the member \"frame\" is \"world_metres\"");
  ExpectRefused(FeatureWith({{"kind", "lava"}}),
                "feature 0: the property \"kind\" is \"lava\": expected one of keep-out");
  ExpectRefused(FeatureWith({{"kind", 3}}), "the property \"kind\" is not a text");
  ExpectRefused(FeatureWith(nullptr), "it has no properties");
  ExpectRefused(FeatureWith({{"kind", "speed-limit"}}), "speed_limit_mps is 0");
  ExpectRefused(FeatureWith({{"kind", "speed-limit"}, {"speed_limit_mps", "fast"}}),
                "\"speed_limit_mps\" is not a number");
  ExpectRefused(FeatureWith({{"kind", "room"}, {"robot_types", "all"}}), "\"robot_types\" is not a list");
  ExpectRefused(FeatureWith({{"kind", "room"}, {"robot_types", {1}}}), "a type that is not a text");
  ExpectRefused(FeatureWith({{"kind", "room"}, {"valid_from", "tomorrow"}}), "\"valid_from\" is \"tomorrow\"");
  ExpectRefused(FeatureWith({{"kind", "room"}, {"valid_until", "infinite-future"}}), "\"infinite-future\"");
  ExpectRefused(FeatureWith({{"kind", "room"}}, {{0, 0}, {1, 0}, {1, 1}}), "the ring has 3 positions");
  ExpectRefused(FeatureWith({{"kind", "room"}}, {{0, 0}, {1, 0}, {1, 1}, {2, 2}}), "the last one being the first one");
  ExpectRefused(FeatureWith({{"kind", "room"}}, {{0, 0}, {1, "a"}, {1, 1}, {0, 0}}), "position 1 is not two numbers");
  ExpectRefused(FeatureWith({{"kind", "room"}}, {{0, 0}, {1, 1}, {1, 0}, {0, 1}, {0, 0}}), "sides 0 and 2 cross");
  json holed = FeatureWith({{"kind", "room"}});
  holed["features"][0]["geometry"]["coordinates"].push_back(json::array());
  ExpectRefused(holed, "the polygon has 2 rings");
  json point = FeatureWith({{"kind", "room"}});
  point["features"][0]["geometry"]["type"] = "Point";
  ExpectRefused(point, "the geometry is not a Polygon");
  json named = FeatureWith({{"kind", "room"}});
  named["features"][0]["id"] = "areas/Not an id";
  ExpectRefused(named, "the id is \"areas/Not an id\"");
}

}  // namespace
}  // namespace enfilade::areas
