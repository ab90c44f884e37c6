// SPDX-License-Identifier: Apache-2.0
// Floor plans in GeoJSON.
#include "core/prior/formats/geojson_plan.h"
#include "tests/fuzz/decoder.h"

namespace enfilade::fuzz {

std::vector<std::string> Seeds() {
  prior::PlanGraph plan;
  plan.corners = {{{0.1, 0}}, {{40, 1.0 / 3}}, {{40, 30}}, {{-1e-7, 30}}};
  plan.walls = {{.from = 0, .to = 1, .thickness = 1.25, .confidence = 0.8}, {.from = 1, .to = 2}, {.from = 3, .to = 2}};
  plan.doors = {{.from = {10, 0}, .to = {18, 0}, .confidence = 0.6}};
  plan.rooms = {{.outline = {{0, 0}, {40, 0}, {40, 30}, {0, 30}}, .name = "Größe \"1\""}};
  plan.shafts = {{.kind = prior::ShaftKind::kStairs, .outline = {{1, 1}, {2, 1}, {2, 2}}, .name = "S"}};
  plan.metres_per_unit = 0.0123456789;
  return {prior::WriteGeoJsonPlan(plan), prior::WriteGeoJsonPlan({}),
          R"({"type": "FeatureCollection", "frame": "metres", "features": [{"type": "Feature", "geometry":)"
          R"( {"type": "MultiPolygon", "coordinates": [[[[0, 0], [4, 0], [4, 3], [0, 3], [0, 0]]]]}}]})",
          R"({"type": "FeatureCollection", "features": [{"type": "Feature", "properties": null, "geometry":)"
          R"( {"type": "MultiLineString", "coordinates": [[[11.5, 48.1], [11.5, 48.1009, 3], [11.501, 48.1009]]]}}]})"};
}

bool Decode(std::string_view bytes) {
  const auto read = prior::ReadGeoJsonPlan(bytes);
  if (!read.ok()) return false;
  Expect(prior::Validate(*read).ok(), "a plan is valid");
  const std::string written = prior::WriteGeoJsonPlan(*read);
  const auto again = prior::ReadGeoJsonPlan(written);
  Expect(again.ok() && prior::WriteGeoJsonPlan(*again) == written, "a plan is read back");
  return true;
}

}  // namespace enfilade::fuzz
