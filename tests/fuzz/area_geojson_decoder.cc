// SPDX-License-Identifier: Apache-2.0
#include "core/areas/area_geojson.h"
#include "tests/fuzz/decoder.h"

namespace enfilade::fuzz {

std::vector<std::string> Seeds() {
  areas::NamedArea ramp{MapAreaId("ramp"), {}};
  ramp.area.kind = areas::AreaKind::kSpeedLimit;
  ramp.area.display_name = "Ramp";
  ramp.area.outline = {{0.5, 0.25}, {4, 0}, {4, 3.125}, {2, 1}};
  ramp.area.robot_types = {"cleaner", "forklift"};
  ramp.area.speed_limit_mps = 0.3;
  ramp.area.valid_from = 1'767'225'600'000'000'000;
  ramp.area.valid_until = 1'767'225'600'123'456'000;
  areas::NamedArea room{{}, {}};
  room.area.kind = areas::AreaKind::kRoom;
  room.area.display_name = "Größe";
  room.area.outline = {{-1, -1}, {1, -1}, {0, 1}};
  return {
      areas::WriteAreasGeoJson({ramp, room}), areas::WriteAreasGeoJson({}),
      R"({"type": "FeatureCollection", "features": [{"type": "Feature", "id": 3, "properties": {"kind": "dock",)"
      R"( "name": null}, "geometry": {"type": "Polygon", "coordinates": [[[0, 0], [1, 0, 5], [1, 1], [0, 0]]]}}]})"};
}

bool Decode(std::string_view bytes) {
  const auto read = areas::ReadAreasGeoJson(bytes);
  if (!read.ok()) return false;
  for (const areas::NamedArea& area : *read) Expect(areas::Validate(area.area).ok(), "an area is valid");
  const std::string written = areas::WriteAreasGeoJson(*read);
  const auto again = areas::ReadAreasGeoJson(written);
  Expect(again.ok() && areas::WriteAreasGeoJson(*again) == written, "areas are read back");
  return true;
}

}  // namespace enfilade::fuzz
