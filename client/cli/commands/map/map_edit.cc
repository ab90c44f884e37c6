// SPDX-License-Identifier: Apache-2.0
// `enfilade map create` and `enfilade map update`.
#include <iostream>
#include <memory>
#include <optional>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"
#include "enfilade/v1/map_service.grpc.pb.h"

namespace enfilade::cli {
namespace {

struct MapEditCommandOptions {
  std::string map;  // to update
  std::string id;
  std::optional<std::string> name;
  std::optional<int> level;
  std::optional<std::string> environment;
  std::optional<std::string> slam_profile;
  std::vector<double> outline;  // x y x y ...
};

absl::Status FillMap(const MapEditCommandOptions& options, v1::Map& map, google::protobuf::FieldMask& mask) {
  if (options.name) {
    map.set_display_name(*options.name);
    mask.add_paths("display_name");
  }
  if (options.level) {
    map.set_level(*options.level);
    mask.add_paths("level");
  }
  if (options.environment) {
    map.set_environment(*options.environment == "outdoor" ? v1::Map::ENVIRONMENT_OUTDOOR : v1::Map::ENVIRONMENT_INDOOR);
    mask.add_paths("environment");
  }
  if (options.slam_profile) {
    map.set_slam_profile(*options.slam_profile);
    mask.add_paths("slam_profile");
  }
  if (options.outline.empty()) return absl::OkStatus();
  if (options.outline.size() % 2 != 0)
    return InvalidArgument("--outline has an odd number of coordinates: the last y is missing");
  mask.add_paths("outline");
  for (std::size_t i = 0; i < options.outline.size(); i += 2) {
    v1::Point& corner = *map.mutable_outline()->add_corners();
    corner.set_x(options.outline[i]);
    corner.set_y(options.outline[i + 1]);
  }
  return absl::OkStatus();
}

void PrintMap(const Globals& globals, const char* what, const v1::Map& map) {
  if (globals.json) {
    PrintJson(std::cout, {{"name", map.name()}, {"display_name", map.display_name()}, {"etag", map.etag()}});
  } else {
    std::cout << what << " \"" << map.display_name() << "\" (" << map.name() << ")\n";
  }
}

absl::Status CreateMap(const Globals& globals, const MapEditCommandOptions& options) {
  v1::CreateMapRequest request;
  google::protobuf::FieldMask ignored;
  ENFILADE_RETURN_IF_ERROR(FillMap(options, *request.mutable_map(), ignored));
  request.set_parent(SiteNameOf(globals));
  request.set_map_id(options.id);
  request.set_request_id(NewUuid());
  ENFILADE_ASSIGN_OR_RETURN(const auto response, ConnectionOf(globals).Call(&v1::MapService::Stub::CreateMap, request));
  PrintMap(globals, "created", response.map());
  return absl::OkStatus();
}

absl::Status UpdateMap(const Globals& globals, const MapEditCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map found, FindMap(connection, globals, options.map));
  v1::UpdateMapRequest request;
  ENFILADE_RETURN_IF_ERROR(FillMap(options, *request.mutable_map(), *request.mutable_update_mask()));
  if (request.update_mask().paths().empty()) return InvalidArgument("nothing to change: give an option (see --help)");
  request.mutable_map()->set_name(found.name());
  request.mutable_map()->set_etag(found.etag());
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&v1::MapService::Stub::UpdateMap, request));
  PrintMap(globals, "updated", response.map());
  return absl::OkStatus();
}

void AddFields(CLI::App& command, const std::shared_ptr<MapEditCommandOptions>& options) {
  command.add_option("--level", options->level, "The floor; 0 is the ground");
  command.add_option("--environment", options->environment, "indoor or outdoor")
      ->check(CLI::IsMember({"indoor", "outdoor"}));
  command.add_option("--slam-profile", options->slam_profile, "The name of the SLAM configuration to map it with");
  command.add_option("--outline", options->outline, "Its corners in its frame: X Y X Y X Y ... in metres")
      ->expected(6, 2000);
}

}  // namespace

void AddMapEdit(CLI::App& map, const Globals& globals) {
  const auto options = std::make_shared<MapEditCommandOptions>();
  CLI::App* create =
      AddCommand(map, "create", "Create an empty map", [&globals, options] { return CreateMap(globals, *options); });
  create->add_option("NAME", options->name, "Its name for people, unique in the site")->required();
  create->add_option("--id", options->id, "Its id: 1 to 63 of a-z, 0-9 and \"-\" (default: a new one)");
  AddFields(*create, options);
  create->footer("Example: enfilade map create \"Main hall\" --id hall --level 1");
  CLI::App* update = AddCommand(map, "update", "Change a map's name, level, environment, profile or outline",
                                [&globals, options] { return UpdateMap(globals, *options); });
  update->add_option("MAP", options->map, "Its name, id or resource name")->required();
  update->add_option("--name", options->name, "A new name");
  AddFields(*update, options);
  update->footer("Example: enfilade map update \"Main hall\" --name \"Great hall\" --outline 0 0 20 0 20 9 0 9");
}

}  // namespace enfilade::cli
