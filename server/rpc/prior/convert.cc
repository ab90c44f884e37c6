// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/prior/convert.h"

#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "proto/convert/record.h"
#include "server/rpc/link_point/convert.h"

namespace enfilade::server {
namespace {

v1::PriorAlignment AlignmentToProto(const SiteId& site, const storage::PriorMapAlignment& alignment) {
  v1::PriorAlignment out;
  const Eigen::Matrix2d& linear = alignment.T_world_sheet.linear;
  const Eigen::Vector2d& offset = alignment.T_world_sheet.offset;
  for (const double value : {linear(0, 0), linear(0, 1), offset.x(), linear(1, 0), linear(1, 1), offset.y()}) {
    out.add_affine_world_sheet(value);
  }
  out.set_model(static_cast<v1::PriorAlignment::Model>(static_cast<int>(alignment.model) + 1));
  out.set_mirrored(alignment.T_world_sheet.mirrored());
  out.set_explained(alignment.explained);
  out.set_contradicted(alignment.contradicted);
  out.set_rival_ratio(alignment.rival_ratio);
  for (const MapId& map : alignment.maps) out.add_maps(NameOf(site, map));
  out.set_graph_version(alignment.graph_version);
  for (const storage::PriorMapPair& pair : alignment.pairs) {
    v1::ControlPair& out_pair = *out.add_pairs();
    out_pair.set_sheet_x(pair.point_sheet.x());
    out_pair.set_sheet_y(pair.point_sheet.y());
    if (!pair.map.empty()) out_pair.set_map(NameOf(site, pair.map));
    out_pair.set_x_m(pair.point_map.x());
    out_pair.set_y_m(pair.point_map.y());
  }
  out.set_tied_walls(alignment.tied_walls);
  for (const MapId& map : alignment.joined_maps) out.add_joined_maps(NameOf(site, map));
  *out.mutable_align_time() = convert::ToTimestamp(alignment.time);
  return out;
}

}  // namespace

v1::PriorMap ToProto(const storage::PriorMap& prior_map) {
  v1::PriorMap out;
  out.set_name(NameOf(prior_map.site, prior_map.id));
  out.set_display_name(prior_map.display_name);
  out.set_level(prior_map.level);
  out.set_state(static_cast<v1::PriorMap::State>(prior_map.state));
  out.set_reason(prior_map.reason);
  out.set_file_name(prior_map.file_name);
  v1::PriorMapElements& elements = *out.mutable_elements();
  elements.set_walls(prior_map.elements.walls);
  elements.set_corners(prior_map.elements.corners);
  elements.set_doors(prior_map.elements.doors);
  elements.set_rooms(prior_map.elements.rooms);
  elements.set_shafts(prior_map.elements.shafts);
  elements.set_metres_per_unit(prior_map.elements.metres_per_unit.value_or(0.0));
  for (const std::string& warning : prior_map.warnings) out.add_warnings(warning);
  if (prior_map.alignment) *out.mutable_alignment() = AlignmentToProto(prior_map.site, *prior_map.alignment);
  out.set_etag(std::to_string(prior_map.etag));
  *out.mutable_create_time() = convert::ToTimestamp(prior_map.create_time);
  *out.mutable_update_time() = convert::ToTimestamp(prior_map.update_time);
  return out;
}

absl::StatusOr<std::vector<storage::PriorMapPair>> PairsOf(
    const SiteId& site, const google::protobuf::RepeatedPtrField<v1::ControlPair>& pairs) {
  std::vector<storage::PriorMapPair> result;
  for (const v1::ControlPair& pair : pairs) {
    const std::string field = fmt::format("pairs[{}]", result.size());
    storage::PriorMapPair one;
    if (!pair.map().empty()) {
      ENFILADE_ASSIGN_OR_RETURN(one.map, MapOfSite(field + ".map", site, pair.map()));
    }
    one.point_sheet = {pair.sheet_x(), pair.sheet_y()};
    one.point_map = {pair.x_m(), pair.y_m()};
    if (!one.point_sheet.allFinite() || !one.point_map.allFinite()) {
      return InvalidArgument("{} has a coordinate that is not finite", field);
    }
    result.push_back(std::move(one));
  }
  return result;
}

absl::StatusOr<perception::ReadPlanOptions> ReadPlanOptionsOf(const v1::ImportPriorMapManifest& manifest) {
  perception::ReadPlanOptions options;
  if (manifest.page() < 0) return InvalidArgument("manifest.page is {}: expected 1 or more, or 0", manifest.page());
  options.page = manifest.page();
  options.layers.assign(manifest.layers().begin(), manifest.layers().end());
  options.level = manifest.plan_level();
  if (!manifest.has_measure()) return options;
  ENFILADE_ASSIGN_OR_RETURN(options.measure, MeasureOf("manifest.measure", manifest.measure()));
  return options;
}

absl::StatusOr<perception::PlanMeasure> MeasureOf(const std::string& field, const v1::PlanMeasure& measure) {
  perception::PlanMeasure known;
  known.from = {measure.from_x(), measure.from_y()};
  known.to = {measure.to_x(), measure.to_y()};
  known.metres = measure.length_m();
  const double length = (known.to - known.from).norm();
  if (!(known.metres > 0) || !std::isfinite(known.metres) || !(length > 0) || !std::isfinite(length)) {
    return InvalidArgument("{}: expected two points and the metres between them", field);
  }
  return known;
}

storage::PriorMapElements ElementsOf(const prior::PlanGraph& plan) {
  storage::PriorMapElements elements;
  elements.walls = static_cast<int>(plan.walls.size());
  elements.corners = static_cast<int>(plan.corners.size());
  elements.doors = static_cast<int>(plan.doors.size());
  elements.rooms = static_cast<int>(plan.rooms.size());
  elements.shafts = static_cast<int>(plan.shafts.size());
  elements.metres_per_unit = plan.metres_per_unit;
  return elements;
}

absl::StatusOr<std::vector<storage::PriorMapProduct>> ProductsOf(const google::protobuf::RepeatedField<int>& products) {
  std::vector<storage::PriorMapProduct> result;
  for (const int product : products) {
    if (product == v1::PRIOR_MAP_PRODUCT_UNSPECIFIED || !v1::PriorMapProduct_IsValid(product)) {
      return InvalidArgument("products[{}] is {}, which is unknown", result.size(), product);
    }
    result.push_back(static_cast<storage::PriorMapProduct>(product));
  }
  return result;
}

}  // namespace enfilade::server
