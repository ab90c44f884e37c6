// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/maps/prior_map_rows.h"

#include <array>
#include <string>
#include <utility>

namespace enfilade::storage::postgres {
namespace {

PriorMapAlignment ReadAlignment(Row& row, TimeNs time) {
  PriorMapAlignment alignment;
  alignment.time = time;
  std::array<double, 6> affine{};
  row.DoublesInto(absl::MakeSpan(affine));
  alignment.T_world_sheet.linear << affine[0], affine[1], affine[3], affine[4];
  alignment.T_world_sheet.offset << affine[2], affine[5];
  alignment.model = static_cast<prior::TransformModel>(row.Int16() - 1);
  alignment.explained = row.Double();
  alignment.contradicted = row.Double();
  alignment.rival_ratio = row.Double();
  for (std::string& map : row.OptionalTexts()) alignment.maps.emplace_back(std::move(map));
  alignment.graph_version = row.Int64();
  const std::vector<std::string> maps = row.OptionalTexts();
  const std::vector<double> points = row.Doubles();
  for (std::size_t i = 0; i < maps.size() && points.size() == 4 * maps.size(); ++i) {
    const double* point = &points[4 * i];
    alignment.pairs.push_back({{point[0], point[1]}, MapId(maps[i]), {point[2], point[3]}});
  }
  alignment.tied_walls = row.Int32();
  for (std::string& map : row.OptionalTexts()) alignment.joined_maps.emplace_back(std::move(map));
  return alignment;
}

}  // namespace

PriorMap ReadPriorMap(Row& row) {
  PriorMap map;
  map.site = SiteId(std::string(row.Text()));
  map.id = PriorMapId(std::string(row.Text()));
  map.display_name = row.Text();
  map.level = row.Int32();
  map.state = static_cast<PriorMapState>(row.Int16());
  map.reason = row.Text();
  map.file_name = row.Text();
  map.warnings = row.OptionalTexts();
  map.elements.walls = row.Int32();
  map.elements.corners = row.Int32();
  map.elements.doors = row.Int32();
  map.elements.rooms = row.Int32();
  map.elements.shafts = row.Int32();
  map.elements.metres_per_unit = row.OptionalDouble();
  map.etag = row.Int64();
  map.create_time = row.Time();
  map.update_time = row.Time();
  if (const std::optional<TimeNs> time = row.OptionalTime()) map.alignment = ReadAlignment(row, *time);
  return map;
}

}  // namespace enfilade::storage::postgres
