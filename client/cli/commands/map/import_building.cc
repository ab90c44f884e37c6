// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/map/import_building.h"

#include <iostream>
#include <memory>

#include "client/cli/commands/map/import_report.h"
#include "client/cli/remote.h"
#include "client/sources/imports/building_file.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "io/file.h"

namespace enfilade::cli {
namespace {

struct BuildingCommandOptions {
  std::string path;
  std::string prefix;
};

class BuildingImport {
 public:
  BuildingImport(const Globals& globals, const client::Connection& connection, std::string prefix)
      : globals_(globals), connection_(connection), prefix_(std::move(prefix)) {}

  absl::Status Run(const sources::Building& building) {
    for (const sources::BuildingRemark& remark : building.remarks) {
      if (remark.refused) {
        report_.Refused(remark.item, remark.why);
      } else {
        report_.Remark(remark.item, remark.why);
      }
    }
    for (const sources::BuildingLevel& level : building.levels) ENFILADE_RETURN_IF_ERROR(TakeLevel(level));
    for (const sources::BuildingLift& lift : building.lifts) ENFILADE_RETURN_IF_ERROR(TakeLift(lift));
    for (std::size_t i = 0; i < building.levels.size(); ++i) {
      for (const sources::BuildingDoor& door : building.levels[i].doors)
        ENFILADE_RETURN_IF_ERROR(TakeDoor(i, door, building));
    }
    return absl::OkStatus();
  }
  const Report& report() const { return report_; }

 private:
  absl::Status TakeLevel(const sources::BuildingLevel& level) {
    v1::CreateMapRequest request;
    request.set_parent(SiteNameOf(globals_));
    request.mutable_map()->set_display_name(prefix_ + level.name);
    request.mutable_map()->set_level(level.level);
    for (const Eigen::Vector2d& corner : level.outline) {
      v1::Point& added = *request.mutable_map()->mutable_outline()->add_corners();
      added.set_x(corner.x());
      added.set_y(corner.y());
    }
    const auto created = connection_.Call(&v1::MapService::Stub::CreateMap, request);
    if (EndsImport(created.status())) return created.status();
    maps_.push_back(created.ok() ? created->map().name() : "");
    if (created.ok()) {
      report_.Taken("levels " + level.name, created->map().name());
    } else {
      report_.Refused("levels " + level.name, std::string(created.status().message()));
    }
    return absl::OkStatus();
  }

  void AddAnchor(std::size_t level, const Pose2& pose, v1::LinkPoint& link_point) {
    if (maps_[level].empty()) return;
    v1::Anchor& anchor = *link_point.add_anchors();
    anchor.set_map(maps_[level]);
    v1::Pose2& place = *anchor.mutable_pose_map_place()->mutable_pose();
    place.set_x(pose.x);
    place.set_y(pose.y);
    place.set_yaw(pose.yaw);
  }

  absl::Status Create(const std::string& item, const std::string& tag, v1::LinkPoint link_point) {
    if (link_point.anchors().empty()) {
      report_.Refused(item, "none of its levels was taken");
      return absl::OkStatus();
    }
    v1::CreateLinkPointRequest request;
    request.set_parent(SiteNameOf(globals_));
    *request.mutable_link_point() = std::move(link_point);
    request.mutable_link_point()->set_tag(tag);
    const auto created = connection_.Call(&v1::LinkPointService::Stub::CreateLinkPoint, request);
    if (EndsImport(created.status())) return created.status();
    if (created.ok()) {
      report_.Taken(item, created->link_point().name(),
                    created->link_point().anchors_size() < 2 ? "a candidate: seen from one map" : "");
    } else {
      report_.Refused(item, std::string(created.status().message()));
    }
    return absl::OkStatus();
  }

  absl::Status TakeLift(const sources::BuildingLift& lift) {
    v1::LinkPoint link_point;
    link_point.set_kind(v1::LinkPoint::KIND_LIFT);
    for (const sources::BuildingLift::Stop& stop : lift.stops) AddAnchor(stop.level, stop.T_level_cabin, link_point);
    return Create("lifts " + lift.name, lift.name, std::move(link_point));
  }

  // Both sides of a door are in the one map of its level.
  absl::Status TakeDoor(std::size_t level, const sources::BuildingDoor& door, const sources::Building& building) {
    v1::LinkPoint link_point;
    link_point.set_kind(v1::LinkPoint::KIND_DOOR);
    AddAnchor(level, door.T_level_door, link_point);
    return Create(fmt::format("levels {} doors {}", building.levels[level].name, door.name), door.name,
                  std::move(link_point));
  }

  const Globals& globals_;
  const client::Connection& connection_;
  const std::string prefix_;
  std::vector<std::string> maps_;  // resource names by level; empty where it was refused
  Report report_;
};

absl::Status ImportBuilding(const Globals& globals, const BuildingCommandOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const std::string yaml, io::ReadFile(options.path));
  ENFILADE_ASSIGN_OR_RETURN(const sources::Building building, sources::ParseBuilding(yaml));
  const client::Connection connection = ConnectionOf(globals);
  const std::string prefix = options.prefix.empty() && !building.name.empty() ? building.name + " " : options.prefix;
  BuildingImport import(globals, connection, prefix);
  const absl::Status status = import.Run(building);
  import.report().Print(globals);
  return status;
}

}  // namespace

void AddImportBuilding(CLI::App& import, const Globals& globals) {
  const auto options = std::make_shared<BuildingCommandOptions>();
  CLI::App* command = AddCommand(import, "building", "Levels, doors and lifts of an Open-RMF building.yaml",
                                 [&globals, options] { return ImportBuilding(globals, *options); });
  command->add_option("FILE", options->path, "The traffic editor's building.yaml")->required();
  command->add_option("--prefix", options->prefix, "Begins the maps' names (default: the building's name)");
  command->footer("Example: enfilade --site campus import building hotel.building.yaml");
}

}  // namespace enfilade::cli
