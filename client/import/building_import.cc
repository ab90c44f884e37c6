// SPDX-License-Identifier: Apache-2.0
#include "client/import/building_import.h"

#include <utility>
#include <vector>

#include "client/sdk/api/map_import.h"
#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "proto/convert/record.h"

namespace enfilade::client {
namespace {

class BuildingImport {
 public:
  BuildingImport(const Connection& connection, const SiteId& site, std::string prefix,
                 const std::vector<LevelDrawing>& drawings, ImportReport& report)
      : connection_(connection),
        site_(NameOf(site)),
        prefix_(std::move(prefix)),
        drawings_(drawings),
        report_(report) {}

  absl::Status Run(const prior::Building& building) {
    for (const prior::BuildingRemark& remark : building.remarks) {
      if (remark.refused) {
        report_.Refused(remark.item, remark.why);
      } else {
        report_.Remark(remark.item, remark.why);
      }
    }
    for (std::size_t i = 0; i < building.levels.size(); ++i) ENFILADE_RETURN_IF_ERROR(TakeLevel(building.levels[i], i));
    for (const prior::BuildingLift& lift : building.lifts) ENFILADE_RETURN_IF_ERROR(TakeLift(lift));
    for (std::size_t i = 0; i < building.levels.size(); ++i) {
      for (const prior::BuildingDoor& door : building.levels[i].doors) {
        ENFILADE_RETURN_IF_ERROR(TakeDoor(i, door, building));
      }
    }
    return absl::OkStatus();
  }

 private:
  absl::Status TakeLevel(const prior::BuildingLevel& level, std::size_t index) {
    v1::CreateMapRequest request;
    request.set_parent(site_);
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
      return DrawLevel("levels " + level.name, index);
    }
    report_.Refused("levels " + level.name, std::string(created.status().message()));
    return absl::OkStatus();
  }

  absl::Status DrawLevel(const std::string& item, std::size_t index) {
    if (index >= drawings_.size() || drawings_[index].empty()) return absl::OkStatus();
    const absl::Status status = ImportMap(connection_, maps_[index], v1::MAP_DIALECT_NAV2, drawings_[index]).status();
    if (EndsImport(status)) return status;
    if (!status.ok()) report_.Remark(item, "its walls are not drawn: " + std::string(status.message()));
    return absl::OkStatus();
  }

  void AddAnchor(std::size_t level, const Pose2& pose, v1::LinkPoint& link_point) {
    if (maps_[level].empty()) return;
    v1::Anchor& anchor = *link_point.add_anchors();
    anchor.set_map(maps_[level]);
    *anchor.mutable_pose_map_place()->mutable_pose() = convert::ToProto(pose);
  }

  absl::Status Create(const std::string& item, const std::string& tag, v1::LinkPoint link_point) {
    if (link_point.anchors().empty()) {
      report_.Refused(item, "none of its levels was taken");
      return absl::OkStatus();
    }
    v1::CreateLinkPointRequest request;
    request.set_parent(site_);
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

  absl::Status TakeLift(const prior::BuildingLift& lift) {
    v1::LinkPoint link_point;
    link_point.set_kind(v1::LinkPoint::KIND_LIFT);
    for (const prior::BuildingLift::Stop& stop : lift.stops) AddAnchor(stop.level, stop.T_level_cabin, link_point);
    return Create("lifts " + lift.name, lift.name, std::move(link_point));
  }

  // Both sides of a door are in the one map of its level.
  absl::Status TakeDoor(std::size_t level, const prior::BuildingDoor& door, const prior::Building& building) {
    v1::LinkPoint link_point;
    link_point.set_kind(v1::LinkPoint::KIND_DOOR);
    AddAnchor(level, door.T_level_door, link_point);
    return Create(fmt::format("levels {} doors {}", building.levels[level].name, door.name), door.name,
                  std::move(link_point));
  }

  const Connection& connection_;
  const std::string site_;
  const std::string prefix_;
  const std::vector<LevelDrawing>& drawings_;
  std::vector<std::string> maps_;  // resource names by level; empty if it was refused
  ImportReport& report_;
};

}  // namespace

absl::Status ImportBuilding(const Connection& connection, const SiteId& site, const prior::Building& building,
                            const std::string& prefix, const std::vector<LevelDrawing>& drawings,
                            ImportReport& report) {
  return BuildingImport(connection, site, prefix, drawings, report).Run(building);
}

}  // namespace enfilade::client
