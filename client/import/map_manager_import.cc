// SPDX-License-Identifier: Apache-2.0
#include "client/import/map_manager_import.h"

#include <cstdint>
#include <map>
#include <string>

#include "client/sdk/api/evidence.h"
#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "proto/convert/record.h"

namespace enfilade::client {
namespace {

std::string Message(const absl::Status& status) { return std::string(status.message()); }

std::string IdOfNumber(const std::string& prefix, std::int64_t id) {
  return id < 0 ? fmt::format("{}-minus-{}", prefix, -id) : fmt::format("{}-{}", prefix, id);
}

class MapManagerImport {
 public:
  MapManagerImport(const Connection& connection, const SiteId& site, ImportReport& report)
      : connection_(connection), site_(NameOf(site)), report_(report) {}

  absl::Status Run(const sources::MapManagerContent& content) {
    for (const sources::MapManagerRemark& remark : content.remarks) {
      if (remark.refused) {
        report_.Refused(remark.row, remark.why);
      } else {
        report_.Remark(remark.row, remark.why);
      }
    }
    for (const sources::MapManagerMap& map : content.maps) ENFILADE_RETURN_IF_ERROR(TakeMap(map));
    for (const sources::MapManagerPlace& place : content.places) ENFILADE_RETURN_IF_ERROR(TakePlace(place));
    return absl::OkStatus();
  }

 private:
  absl::Status TakeMap(const sources::MapManagerMap& map) {
    const std::string row = fmt::format("MAPS {}", map.id);
    v1::CreateMapRequest request;
    request.set_parent(site_);
    request.set_map_id(IdOfNumber("map", map.id));
    request.mutable_map()->set_display_name(map.name.empty() ? request.map_id() : map.name);
    request.mutable_map()->set_environment(map.indoor ? v1::Map::ENVIRONMENT_INDOOR : v1::Map::ENVIRONMENT_OUTDOOR);
    const std::string name = request.parent() + "/maps/" + request.map_id();
    auto created = connection_.Call(&v1::MapService::Stub::CreateMap, request);
    std::string remark;
    if (absl::IsAlreadyExists(created.status())) {
      v1::GetMapRequest get;
      get.set_name(name);
      if (connection_.Call(&v1::MapService::Stub::GetMap, get).ok()) {
        maps_[map.id] = name;
        report_.Refused(row, name + " exists already: its link points join that one");
        return absl::OkStatus();
      }
      // Two maps of the database may have the same name.
      remark = fmt::format("its name \"{}\" was taken", map.name);
      request.mutable_map()->set_display_name(fmt::format("{} ({})", map.name, map.id));
      created = connection_.Call(&v1::MapService::Stub::CreateMap, request);
    }
    if (EndsImport(created.status())) return created.status();
    if (created.ok()) {
      maps_[map.id] = name;
      report_.Taken(row, name, remark);
    } else {
      report_.Refused(row, Message(created.status()));
    }
    return absl::OkStatus();
  }

  absl::Status TakePlace(const sources::MapManagerPlace& place) {
    const std::string row = fmt::format("{} {}", place.candidate ? "LINKPOINTCANDIDATES" : "LINKPOINTS", place.id);
    v1::CreateLinkPointRequest request;
    request.set_parent(site_);
    request.set_link_point_id(IdOfNumber(place.candidate ? "candidate" : "linkpoint", place.id));
    v1::LinkPoint& link_point = *request.mutable_link_point();
    link_point.set_tag(place.tag);
    link_point.set_difficulty(place.difficulty);
    if (place.indoor) {
      link_point.set_environment(*place.indoor ? v1::Map::ENVIRONMENT_INDOOR : v1::Map::ENVIRONMENT_OUTDOOR);
    }
    for (const sources::MapManagerPlace::Anchor& anchor : place.anchors) {
      if (!maps_.contains(anchor.map)) {
        report_.Refused(row, fmt::format("its map {} was not taken", anchor.map));
        return absl::OkStatus();
      }
      v1::Anchor& added = *link_point.add_anchors();
      added.set_map(maps_[anchor.map]);
      *added.mutable_pose_map_place()->mutable_pose() = convert::ToProto(anchor.T_map_place);
    }
    if (place.direction) link_point.set_direction_map(maps_[*place.direction]);
    const auto created = connection_.Call(&v1::LinkPointService::Stub::CreateLinkPoint, request);
    if (EndsImport(created.status())) return created.status();
    if (!created.ok()) {
      report_.Refused(row, Message(created.status()));
      return absl::OkStatus();
    }
    report_.Taken(row, created->link_point().name());
    return AttachAll(row, created->link_point(), place);
  }

  absl::Status AttachAll(const std::string& row, const v1::LinkPoint& link_point,
                         const sources::MapManagerPlace& place) {
    v1::Evidence evidence;
    evidence.set_map(link_point.anchors(0).map());
    const auto attach = [&](const char* what, const std::string& bytes) -> absl::Status {
      if (bytes.empty()) return absl::OkStatus();
      absl::Status attached = AttachEvidence(connection_, link_point.name(), evidence, bytes).status();
      if (EndsImport(attached)) return attached;
      if (!attached.ok()) report_.Remark(row, fmt::format("its {} was refused: {}", what, Message(attached)));
      return absl::OkStatus();
    };
    v1::Image& image = *evidence.mutable_image();
    image.mutable_time();  // the database has none: zero
    image.set_encoding(v1::Image::ENCODING_PNG);
    image.set_camera(v1::Image::CAMERA_FRONT);
    ENFILADE_RETURN_IF_ERROR(attach("front image", place.front_image));
    image.set_camera(v1::Image::CAMERA_REAR);
    ENFILADE_RETURN_IF_ERROR(attach("rear image", place.rear_image));
    evidence.mutable_cloud()->mutable_time();
    evidence.mutable_cloud()->set_encoding(v1::PointCloud::ENCODING_PCD);
    return attach("point cloud", place.cloud);
  }

  const Connection& connection_;
  const std::string site_;
  std::map<std::int64_t, std::string> maps_;  // resource names
  ImportReport& report_;
};

}  // namespace

absl::Status ImportMapManager(const Connection& connection, const SiteId& site,
                              const sources::MapManagerContent& content, ImportReport& report) {
  return MapManagerImport(connection, site, report).Run(content);
}

}  // namespace enfilade::client
