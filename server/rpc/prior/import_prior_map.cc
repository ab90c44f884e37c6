// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/prior/import_prior_map.h"

#include <algorithm>
#include <cctype>
#include <optional>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "core/prior/formats/geojson_plan.h"
#include "perception/plan/read_plan.h"
#include "proto/convert/names.h"
#include "server/rpc/call/client_stream.h"
#include "server/rpc/map/file_assembly.h"
#include "server/rpc/prior/convert.h"
#include "server/rpc/resources.h"

namespace enfilade::server {
namespace {

constexpr std::size_t kMaxFileName = 255;
constexpr std::size_t kMaxExtension = 16;

// Its name beside those of the products. The extension tells viewers what it is.
std::string SheetName(const std::string& file_name) {
  const std::size_t dot = file_name.rfind('.');
  std::string extension = dot == std::string::npos ? "" : file_name.substr(dot + 1);
  const auto is_alphanumeric = [](unsigned char c) { return std::isalnum(c) != 0; };
  if (extension.size() > kMaxExtension || !std::all_of(extension.begin(), extension.end(), is_alphanumeric))
    return "sheet";
  return extension.empty() ? "sheet" : "sheet." + extension;
}

class PriorMapImporter {
 public:
  explicit PriorMapImporter(const Services& services) : services_(services), assembly_(services.uploads) {}

  absl::Status Take(const v1::ImportPriorMapRequest& request) {
    if (request.has_chunk()) return assembly_.Add(request.chunk());
    if (!request.has_manifest() || begun_) {
      return InvalidArgument("expected the manifest as the first message, and chunks after it");
    }
    begun_ = true;
    const v1::ImportPriorMapManifest& manifest = request.manifest();
    ENFILADE_ASSIGN_OR_RETURN(prior_map_.site, convert::ParseSiteName("manifest.parent", manifest.parent()));
    ENFILADE_ASSIGN_OR_RETURN(request_id_, RequestIdOf(manifest));
    const bool is_named = !manifest.prior_map_id().empty() || request_id_.empty();
    ENFILADE_ASSIGN_OR_RETURN(
        std::string id,
        IdOrNew("manifest.prior_map_id", is_named ? manifest.prior_map_id() : IdOfRequest(request_id_.value)));
    prior_map_.id = PriorMapId(std::move(id));
    ENFILADE_RETURN_IF_ERROR(CheckDisplayName("manifest.display_name", manifest.display_name()));
    prior_map_.display_name = manifest.display_name();
    prior_map_.level = manifest.level();
    const std::string& name = manifest.file().name();
    if (name.empty() || name.size() > kMaxFileName || name.find('/') != std::string::npos) {
      return InvalidArgument("manifest.file.name is \"{}\": expected 1 to {} bytes without folders",
                             name.substr(0, kMaxFileName), kMaxFileName);
    }
    prior_map_.file_name = name;
    ENFILADE_ASSIGN_OR_RETURN(reading_, ReadPlanOptionsOf(manifest));
    google::protobuf::RepeatedPtrField<v1::FileEntry> files;
    *files.Add() = manifest.file();
    return assembly_.Begin(files,
                           std::min<std::int64_t>(services_.options.transfers.max_import_bytes, sensor::kMaxBlobBytes));
  }

  absl::Status Answer(const storage::CallContext& context, v1::ImportPriorMapResponse& response) {
    ENFILADE_ASSIGN_OR_RETURN(std::vector<grid::MapFile> files, assembly_.Finish());
    // What the site would refuse, or has already, need not be read.
    ENFILADE_RETURN_IF_ERROR(services_.sites.Get(context, prior_map_.site).status());
    const std::string digest = Sha256(files.front().bytes);
    if (!request_id_.empty()) {
      ENFILADE_ASSIGN_OR_RETURN(const std::optional<storage::PriorMap> before, FindImported(context, digest));
      if (before) {
        *response.mutable_prior_map() = ToProto(*before);
        return absl::OkStatus();
      }
    }
    absl::StatusOr<perception::PlanFile> plan = perception::DecodePlan(files.front().bytes, reading_);
    if (!plan.ok()) return WithContext(plan.status(), prior_map_.file_name);
    prior_map_.warnings = std::move(plan->warnings);
    prior_map_.elements = ElementsOf(plan->graph);
    prior_map_.reason = "it was not aligned yet";
    const std::vector<storage::NewPriorMapFile> stored = {
        {storage::PriorMapProduct::kSheet, SheetName(prior_map_.file_name), std::move(files.front().bytes)},
        {storage::PriorMapProduct::kPlan, std::string(kPlanFileName), prior::WriteGeoJsonPlan(plan->graph)}};
    absl::StatusOr<storage::PriorMap> created = services_.prior_maps.Create(context, prior_map_, stored);
    if (absl::IsAlreadyExists(created.status()) && !request_id_.empty()) {  // a call beside this one was faster
      ENFILADE_ASSIGN_OR_RETURN(std::optional<storage::PriorMap> before, FindImported(context, digest));
      if (before) created = *std::move(before);
    }
    ENFILADE_RETURN_IF_ERROR(created.status());
    *response.mutable_prior_map() = ToProto(*created);
    return absl::OkStatus();
  }

 private:
  // What an earlier call with the same request id has created. INVALID_ARGUMENT if that asked for something else.
  absl::StatusOr<std::optional<storage::PriorMap>> FindImported(const storage::CallContext& context,
                                                                const std::string& digest) const {
    absl::StatusOr<storage::PriorMap> found = services_.prior_maps.Get(context, prior_map_.site, prior_map_.id);
    if (absl::IsNotFound(found.status())) return std::nullopt;
    ENFILADE_RETURN_IF_ERROR(found.status());
    ENFILADE_ASSIGN_OR_RETURN(const auto files,
                              services_.prior_maps.ListFiles(context, prior_map_.site, prior_map_.id));
    const bool has_file = std::any_of(files.begin(), files.end(), [&](const storage::PriorMapFile& file) {
      return file.product == storage::PriorMapProduct::kSheet && file.sha256 == digest;
    });
    const bool is_same = has_file && found->display_name == prior_map_.display_name &&
                         found->level == prior_map_.level && found->file_name == prior_map_.file_name;
    if (!is_same) return InvalidArgument("request_id \"{}\" was used for another prior map already", request_id_.value);
    return *std::move(found);
  }

  const Services& services_;
  bool begun_ = false;
  storage::PriorMap prior_map_;
  storage::RequestId request_id_;
  perception::ReadPlanOptions reading_;
  FileAssembly assembly_;
};

}  // namespace

grpc::ServerReadReactor<v1::ImportPriorMapRequest>* ImportPriorMap(const Services& services, const CallEntry& entry,
                                                                   v1::ImportPriorMapResponse* response) {
  return RunClientStream<PriorMapImporter, v1::ImportPriorMapRequest>(
      entry, response, [&services] { return PriorMapImporter(services); });
}

}  // namespace enfilade::server
