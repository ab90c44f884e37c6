// SPDX-License-Identifier: Apache-2.0
// `enfilade area add` and `enfilade area update`.
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "client/cli/commands/area/area_fields.h"
#include "client/cli/commands/area/area_output.h"
#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sdk/editing/map_areas.h"
#include "core/areas/area_geojson.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"
#include "enfilade/v1/map_area_service.grpc.pb.h"
#include "io/file.h"
#include "proto/convert/record.h"

namespace enfilade::cli {
namespace {

using MapAreaStub = v1::MapAreaService::Stub;

struct AreaEditOptions {
  std::string map;
  std::string area;  // to update
  std::string id;
  std::string file;
  AreaFields fields;
  bool force = false;
};

v1::MapArea AreaToProto(const areas::MapArea& area) {
  v1::MapArea out;
  out.set_kind(static_cast<v1::MapArea::Kind>(area.kind));
  out.set_display_name(area.display_name);
  for (const Eigen::Vector2d& corner : area.outline) {
    v1::Point& added = *out.mutable_outline()->add_corners();
    added.set_x(corner.x());
    added.set_y(corner.y());
  }
  for (const std::string& type : area.robot_types) out.add_robot_types(type);
  out.set_speed_limit_mps(area.speed_limit_mps);
  if (area.valid_from) *out.mutable_valid_from() = convert::ToTimestamp(*area.valid_from);
  if (area.valid_until) *out.mutable_valid_until() = convert::ToTimestamp(*area.valid_until);
  return out;
}

absl::StatusOr<v1::MapArea> CreateArea(const client::Connection& connection, v1::CreateMapAreaRequest request) {
  request.set_request_id(NewUuid());
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&MapAreaStub::CreateMapArea, request));
  return response.area();
}

absl::Status AddAreasOfFile(const Globals& globals, const client::Connection& connection, const std::string& map,
                            const AreaEditOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const std::string text, io::ReadFile(options.file));
  const auto read = areas::ReadAreasGeoJson(text);
  if (!read.ok()) return WithContext(read.status(), options.file);
  nlohmann::json added = nlohmann::json::array();
  for (std::size_t i = 0; i < read->size(); ++i) {
    v1::CreateMapAreaRequest request;
    request.set_parent(map);
    *request.mutable_area() = AreaToProto((*read)[i].area);
    request.set_area_id((*read)[i].id.value());
    request.set_force(options.force);
    const auto area = CreateArea(connection, std::move(request));
    if (!area.ok()) {
      return WithContext(area.status(), fmt::format("{}: feature {} (those before it are stored)", options.file, i));
    }
    added.push_back(MapAreaToJson(*area));
    if (!globals.json) PrintMapArea(globals, "added", *area);
  }
  if (globals.json) PrintJson(std::cout, added);
  return absl::OkStatus();
}

absl::Status RunAreaAdd(const Globals& globals, const AreaEditOptions& options) {
  const AreaFields& fields = options.fields;
  const bool from_file = !options.file.empty();
  if (from_file == (fields.kind || fields.polygon)) {
    return InvalidArgument("give either --file, or --kind and --polygon (see --help)");
  }
  if (!from_file && !(fields.kind && fields.polygon)) {
    return InvalidArgument("{} is missing: an area has a kind and a polygon", fields.kind ? "--polygon" : "--kind");
  }
  v1::CreateMapAreaRequest request;
  google::protobuf::FieldMask given;
  ENFILADE_RETURN_IF_ERROR(FillArea(fields, *request.mutable_area(), given));
  if (from_file && (given.paths_size() > 0 || !options.id.empty())) {
    return InvalidArgument("--file has all of its areas: give no other option with it but --force");
  }
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, options.map));
  if (from_file) return AddAreasOfFile(globals, connection, map.name(), options);
  request.set_parent(map.name());
  request.set_area_id(options.id);
  request.set_force(options.force);
  if (!fields.name) request.mutable_area()->set_display_name(*fields.kind);
  ENFILADE_ASSIGN_OR_RETURN(const v1::MapArea added, CreateArea(connection, std::move(request)));
  PrintMapArea(globals, "added", added);
  return absl::OkStatus();
}

absl::Status RunAreaUpdate(const Globals& globals, const AreaEditOptions& options) {
  v1::UpdateMapAreaRequest request;
  ENFILADE_RETURN_IF_ERROR(FillArea(options.fields, *request.mutable_area(), *request.mutable_update_mask()));
  if (request.update_mask().paths().empty()) return InvalidArgument("nothing to change: give an option (see --help)");
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, options.map));
  ENFILADE_ASSIGN_OR_RETURN(const v1::MapArea found, client::FindMapArea(connection, map.name(), options.area));
  request.mutable_area()->set_name(found.name());
  request.mutable_area()->set_etag(found.etag());
  request.set_force(options.force);
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&MapAreaStub::UpdateMapArea, request));
  PrintMapArea(globals, "updated", response.area());
  return absl::OkStatus();
}

}  // namespace

void AddAreaEdit(CLI::App& area, const Globals& globals) {
  const auto adding = std::make_shared<AreaEditOptions>();
  CLI::App* add = AddCommand(area, "add", "Add an area to a map, or all areas of a GeoJSON file",
                             [&globals, adding] { return RunAreaAdd(globals, *adding); });
  add->add_option("MAP", adding->map, "Its name, id or resource name")->required();
  AddAreaFields(*add, adding->fields);
  add->add_option("--name", adding->fields.name, "Its name for people (default: its kind)");
  add->add_option("--id", adding->id, "Its id: 1 to 63 of a-z, 0-9 and \"-\" (default: a new one)");
  add->add_option("--file", adding->file, "A GeoJSON file as `enfilade area export` writes it, instead");
  add->add_flag("--force", adding->force, "Also a keep-out area over a link point");
  add->footer(
      "Examples:\n  enfilade area add \"Main hall\" --kind keep-out --polygon \"0,0 4,0 4,2 0,2\" --name Stairs\n"
      "  enfilade area add \"Main hall\" --kind speed-limit --speed 0.3 --polygon \"5,0 9,0 9,2\" --robot-type "
      "forklift\n"
      "  enfilade area add \"Main hall\" --file areas.geojson");
  const auto updating = std::make_shared<AreaEditOptions>();
  CLI::App* update =
      AddCommand(area, "update", "Change an area", [&globals, updating] { return RunAreaUpdate(globals, *updating); });
  update->add_option("MAP", updating->map, "Its name, id or resource name")->required();
  update->add_option("AREA", updating->area, "Its id, resource name or name")->required();
  AddAreaFields(*update, updating->fields);
  update->add_option("--name", updating->fields.name, "A new name");
  update->add_flag("--all-robots", updating->fields.all_robots, "It holds for robots of all types");
  update->add_flag("--force", updating->force, "Also a keep-out area over a link point");
  update->footer("Example: enfilade area update \"Main hall\" Ramp --speed 0.5 --until 2026-12-31T18:00:00Z");
}

}  // namespace enfilade::cli
