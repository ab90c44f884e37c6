// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/base/sha256.h"
#include "core/grid/files/map_files.h"
#include "core/prior/formats/geojson_plan.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "enfilade/v1/prior_map_service.grpc.pb.h"
#include "tests/rpc/server_test.h"
#include "tests/support/plans/drawn_building.h"

namespace enfilade::testing {

// Plan "plan" of a drawn building, and maps of it.
class PriorMapFixture : public ServerTest {
 protected:
  using Files = std::map<std::string, std::string>;
  static constexpr const char* kPlan = "sites/s/priorMaps/plan";

  // Where the plan lies in the world.
  static Eigen::Vector2d Truth(const Eigen::Vector2d& sheet) {
    const double turn = 0.3;
    Eigen::Matrix2d rotation;
    rotation << std::cos(turn), -std::sin(turn), std::sin(turn), std::cos(turn);
    return 0.05 * rotation * Eigen::Vector2d(sheet.x(), -sheet.y()) + Eigen::Vector2d(3.5, -7.25);
  }

  absl::StatusOr<v1::PriorMap> ImportPlan(const std::string& bytes, v1::ImportPriorMapManifest manifest,
                                          const std::string& sha256 = "") const {
    const auto stub = v1::PriorMapService::NewStub(connection_->channel());
    grpc::ClientContext context;
    v1::ImportPriorMapResponse response;
    const auto writer = stub->ImportPriorMap(&context, &response);
    manifest.mutable_file()->set_size_bytes(static_cast<std::int64_t>(bytes.size()));
    manifest.mutable_file()->set_sha256(sha256.empty() ? Sha256(bytes) : sha256);
    v1::ImportPriorMapRequest request;
    *request.mutable_manifest() = manifest;
    writer->Write(request);
    request.mutable_chunk()->set_data(bytes);
    writer->Write(request);
    writer->WritesDone();
    const absl::Status status = client::FromGrpcStatus(writer->Finish());
    if (!status.ok()) return status;
    return response.prior_map();
  }
  static v1::ImportPriorMapManifest Manifest(const std::string& id = "plan", const std::string& name = "Ground floor") {
    v1::ImportPriorMapManifest manifest;
    manifest.set_parent("sites/s");
    manifest.set_prior_map_id(id);
    manifest.set_display_name(name);
    manifest.mutable_file()->set_name("drawing.geojson");
    return manifest;
  }
  absl::StatusOr<v1::PriorMap> ImportDrawnBuilding() const {
    return ImportPlan(prior::WriteGeoJsonPlan(prior::DrawnBuilding()), Manifest());
  }
  // What robots have seen of the building becomes a map, in whose frame the plan lies as `place` says.
  void MapBuilding(const std::function<bool(const Eigen::Vector2d&)>& is_seen, const std::string& map = "m",
                   const prior::Placement& place = Truth) {
    ImportGrid(prior::MapOf(prior::DrawnBuilding(), place, is_seen), map);
  }
  // As the newest revision of the map.
  void ImportGrid(const grid::OccupancyGrid& grid, const std::string& map) const {
    const auto files = grid::RenderFiles(grid::FromOccupancyGrid(grid), "m", {.format = grid::MapFileFormat::kPng});
    ASSERT_OK(files.status());
    const auto stub = v1::MapService::NewStub(connection_->channel());
    grpc::ClientContext context;
    v1::ImportMapResponse response;
    const auto writer = stub->ImportMap(&context, &response);
    v1::ImportMapRequest request;
    request.mutable_manifest()->set_parent("sites/s/maps/" + map);
    for (const grid::MapFile& file : *files) {
      v1::FileEntry& entry = *request.mutable_manifest()->add_files();
      entry.set_name(file.name);
      entry.set_size_bytes(static_cast<std::int64_t>(file.bytes.size()));
      entry.set_sha256(Sha256(file.bytes));
    }
    writer->Write(request);
    for (std::size_t i = 0; i < files->size(); ++i) {
      request.mutable_chunk()->set_file(static_cast<int>(i));
      request.mutable_chunk()->set_data((*files)[i].bytes);
      writer->Write(request);
    }
    writer->WritesDone();
    ASSERT_OK(client::FromGrpcStatus(writer->Finish()));
  }
  absl::StatusOr<v1::AlignPriorMapResponse> Align(v1::AlignPriorMapRequest request = {}) const {
    if (request.name().empty()) request.set_name(kPlan);
    // It computes for many seconds on a busy machine.
    const auto stub = v1::PriorMapService::NewStub(connection_->channel());
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(5));
    v1::AlignPriorMapResponse response;
    const absl::Status status = client::FromGrpcStatus(stub->AlignPriorMap(&context, request, &response));
    if (!status.ok()) return status;
    return response;
  }
  v1::PriorMap Get(const std::string& name = kPlan) const {
    v1::GetPriorMapRequest request;
    request.set_name(name);
    const auto response = Call(&v1::PriorMapService::Stub::GetPriorMap, request);
    EXPECT_OK(response.status());
    return response.ok() ? response->prior_map() : v1::PriorMap();
  }
  absl::StatusOr<Files> Export(const std::vector<v1::PriorMapProduct>& products,
                               const std::string& name = kPlan) const {
    v1::ExportPriorMapRequest request;
    request.set_name(name);
    for (const v1::PriorMapProduct product : products) request.add_products(product);
    const auto stub = v1::PriorMapService::NewStub(connection_->channel());
    grpc::ClientContext context;
    const auto stream = stub->ExportPriorMap(&context, request);
    v1::ExportPriorMapResponse message;
    v1::ExportPriorMapManifest manifest;
    Files files;
    while (stream->Read(&message)) {
      if (message.has_manifest()) {
        manifest = message.manifest();
        continue;
      }
      files[manifest.files(message.chunk().file()).name()] += message.chunk().data();
    }
    const absl::Status status = client::FromGrpcStatus(stream->Finish());
    if (!status.ok()) return status;
    EXPECT_EQ(static_cast<std::size_t>(manifest.files_size()), files.size());
    for (const v1::FileEntry& entry : manifest.files()) EXPECT_EQ(Sha256(files[entry.name()]), entry.sha256());
    return files;
  }
  absl::StatusOr<v1::PriorMap> Activate(const std::string& etag = "", const std::string& name = kPlan) const {
    v1::ActivatePriorMapRequest request;
    request.set_name(name);
    request.set_etag(etag);
    const auto response = Call(&v1::PriorMapService::Stub::ActivatePriorMap, request);
    if (!response.ok()) return response.status();
    return response->prior_map();
  }
  absl::StatusOr<v1::PriorMap> Suspend(const std::string& etag = "", const std::string& name = kPlan) const {
    v1::SuspendPriorMapRequest request;
    request.set_name(name);
    request.set_etag(etag);
    const auto response = Call(&v1::PriorMapService::Stub::SuspendPriorMap, request);
    if (!response.ok()) return response.status();
    return response->prior_map();
  }
  absl::Status Delete(const std::string& etag = "", bool force = false, const std::string& name = kPlan) const {
    v1::DeletePriorMapRequest request;
    request.set_name(name);
    request.set_etag(etag);
    request.set_force(force);
    return Call(&v1::PriorMapService::Stub::DeletePriorMap, request).status();
  }
  void MakeMap(const std::string& id, int level = 0) const {
    v1::CreateMapRequest request;
    request.set_parent("sites/s");
    request.set_map_id(id);
    request.mutable_map()->set_display_name(id);
    request.mutable_map()->set_level(level);
    request.mutable_map()->set_environment(v1::Map::ENVIRONMENT_INDOOR);
    ASSERT_OK(Call(&v1::MapService::Stub::CreateMap, request).status());
  }
  static v1::ControlPair Pair(const Eigen::Vector2d& sheet, const Eigen::Vector2d& point, const std::string& map = "") {
    v1::ControlPair pair;
    pair.set_sheet_x(sheet.x());
    pair.set_sheet_y(sheet.y());
    pair.set_map(map);
    pair.set_x_m(point.x());
    pair.set_y_m(point.y());
    return pair;
  }
  static Eigen::Vector2d Placed(const v1::PriorAlignment& alignment, const Eigen::Vector2d& sheet) {
    const auto& a = alignment.affine_world_sheet();
    return {a[0] * sheet.x() + a[1] * sheet.y() + a[2], a[3] * sheet.x() + a[4] * sheet.y() + a[5]};
  }
  static bool IsWest(const Eigen::Vector2d& sheet) { return sheet.x() < 520; }
  static bool IsOneRoom(const Eigen::Vector2d& sheet) { return sheet.x() < 102 && sheet.y() < 202; }
};

}  // namespace enfilade::testing
