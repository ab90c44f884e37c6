// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/map/import_sources.h"

#include <iostream>
#include <map>
#include <memory>

#include "client/cli/commands/map/import_building.h"
#include "client/cli/commands/map/import_report.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sources/imports/map_manager_database.h"
#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"

namespace enfilade::cli {
namespace {

std::string Message(const absl::Status& status) { return std::string(status.message()); }

std::string IdOfNumber(const std::string& prefix, std::int64_t id) {
  return id < 0 ? fmt::format("{}-minus-{}", prefix, -id) : fmt::format("{}-{}", prefix, id);
}

absl::Status Attach(const client::Connection& connection, const std::string& link_point, v1::Evidence evidence,
                    const std::string& bytes) {
  constexpr std::size_t kChunk = 1U << 20;
  v1::BlobRef content;
  content.set_sha256(Sha256(bytes));
  content.set_size_bytes(static_cast<std::int64_t>(bytes.size()));
  *(evidence.has_cloud() ? evidence.mutable_cloud()->mutable_content() : evidence.mutable_image()->mutable_content()) =
      content;
  const auto stub = v1::LinkPointService::NewStub(connection.channel());
  grpc::ClientContext context;
  connection.SetActor(context);
  connection.SetDeadline(context);
  v1::AttachEvidenceResponse response;
  const auto writer = stub->AttachEvidence(&context, &response);
  v1::AttachEvidenceRequest request;
  request.mutable_manifest()->set_parent(link_point);
  *request.mutable_manifest()->mutable_evidence() = std::move(evidence);
  bool open = writer->Write(request);
  for (std::size_t offset = 0; open && offset < bytes.size(); offset += kChunk) {
    v1::BlobChunk& chunk = *request.mutable_chunk();
    *chunk.mutable_blob() = content;
    chunk.set_offset(static_cast<std::int64_t>(offset));
    chunk.set_data(bytes.substr(offset, kChunk));
    open = writer->Write(request);
  }
  writer->WritesDone();
  return client::FromGrpcStatus(writer->Finish(), connection.address());
}

class MapManagerImport {
 public:
  MapManagerImport(const Globals& globals, const client::Connection& connection)
      : globals_(globals), connection_(connection) {}

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
  const Report& report() const { return report_; }

 private:
  absl::Status TakeMap(const sources::MapManagerMap& map) {
    const std::string row = fmt::format("MAPS {}", map.id);
    v1::CreateMapRequest request;
    request.set_parent(SiteNameOf(globals_));
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
      // Names need not differ there.
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
    request.set_parent(SiteNameOf(globals_));
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
      v1::Pose2& pose = *added.mutable_pose_map_place()->mutable_pose();
      pose.set_x(anchor.T_map_place.x);
      pose.set_y(anchor.T_map_place.y);
      pose.set_yaw(anchor.T_map_place.yaw);
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
      const absl::Status attached = Attach(connection_, link_point.name(), evidence, bytes);
      if (EndsImport(attached)) return attached;
      if (!attached.ok()) report_.Remark(row, fmt::format("its {} was refused: {}", what, Message(attached)));
      return absl::OkStatus();
    };
    v1::Image& image = *evidence.mutable_image();
    image.mutable_time();  // the database does not say
    image.set_encoding(v1::Image::ENCODING_PNG);
    image.set_camera(v1::Image::CAMERA_FRONT);
    ENFILADE_RETURN_IF_ERROR(attach("front image", place.front_image));
    image.set_camera(v1::Image::CAMERA_REAR);
    ENFILADE_RETURN_IF_ERROR(attach("rear image", place.rear_image));
    evidence.mutable_cloud()->mutable_time();
    evidence.mutable_cloud()->set_encoding(v1::PointCloud::ENCODING_PCD);
    return attach("point cloud", place.cloud);
  }

  const Globals& globals_;
  const client::Connection& connection_;
  std::map<std::int64_t, std::string> maps_;  // resource names
  Report report_;
};

absl::Status ImportMapManager(const Globals& globals, const std::string& path) {
  ENFILADE_ASSIGN_OR_RETURN(const sources::MapManagerContent content, sources::ReadMapManagerDatabase(path));
  const client::Connection connection = ConnectionOf(globals);
  MapManagerImport import(globals, connection);
  const absl::Status status = import.Run(content);
  import.report().Print(globals);
  return status;
}

}  // namespace

void AddImport(CLI::App& app, const Globals& globals) {
  CLI::App* group = app.add_subcommand("import", "Take over what other programs have made");
  group->require_subcommand(1);
  const auto path = std::make_shared<std::string>();
  CLI::App* map_manager = AddCommand(*group, "mapmanager", "Maps, link points and candidates of a map_manager database",
                                     [&globals, path] { return ImportMapManager(globals, *path); });
  map_manager->add_option("DATABASE", *path, "Its linkpoints.db; point clouds are read beside it")->required();
  map_manager->footer("Example: enfilade --site campus import mapmanager ~/maps/linkpoints.db");
  AddImportBuilding(*group, globals);
}

}  // namespace enfilade::cli
