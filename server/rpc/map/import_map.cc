#include "server/rpc/map/import_map.h"

#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/app/raster_revision.h"
#include "server/rpc/map/file_assembly.h"
#include "server/rpc/resources.h"
#include "server/rpc/status.h"

namespace enfilade::server {
namespace {

absl::Status Import(const Services& services, const CallContext& context, const MapName& name, MapDialect dialect,
                    FileAssembly& assembly, v1::ImportMapResponse& response) {
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<MapFile> files, assembly.Finish());
  ENFILADE_ASSIGN_OR_RETURN(const ImportedMap imported, ImportFiles(files, dialect));
  for (const std::string& warning : imported.warnings) response.add_warnings(warning);
  ENFILADE_ASSIGN_OR_RETURN(RasterRevision raster, ToRevision(imported.raster));
  raster.revision.source = RevisionSource::kImport;
  ENFILADE_RETURN_IF_ERROR(PutTiles(context, services.blobs, name.site, raster, {}));
  ENFILADE_ASSIGN_OR_RETURN(const MapRevision revision,
                            services.revisions.Add(context, name.site, name.map, raster.revision, {}));
  *response.mutable_revision() = ToProto(revision);
  return absl::OkStatus();
}

class ImportMapReactor final : public grpc::ServerReadReactor<v1::ImportMapRequest> {
 public:
  ImportMapReactor(const Services& services, grpc::CallbackServerContext* call, v1::ImportMapResponse* response)
      : services_(services),
        context_(ContextOf(*call, std::chrono::duration<double>(services.options.database.default_deadline_s))),
        response_(response) {
    StartRead(&request_);
  }

  void OnReadDone(bool ok) override {
    if (!ok) return EndOfFiles();
    const absl::Status status = Take();
    if (status.ok()) return StartRead(&request_);
    Answer(status);
  }

  void OnDone() override {
    services_.metrics.CountCall("ImportMap", status_.code(), std::chrono::steady_clock::now() - begin_);
    delete this;
  }

 private:
  absl::Status Take() {
    if (request_.has_chunk()) return assembly_.Add(request_.chunk());
    if (!request_.has_manifest() || begun_) {
      return InvalidArgument("expected the manifest as the first message, and chunks after it");
    }
    begun_ = true;
    const v1::ImportMapManifest& manifest = request_.manifest();
    ENFILADE_ASSIGN_OR_RETURN(name_, ParseMapName("manifest.parent", manifest.parent()));
    if (!v1::MapDialect_IsValid(manifest.dialect())) {
      return InvalidArgument("manifest.dialect is {}: unknown to this server", static_cast<int>(manifest.dialect()));
    }
    if (manifest.dialect() == v1::MAP_DIALECT_ROS1) dialect_ = MapDialect::kRos1;
    return assembly_.Begin(manifest.files(), services_.options.transfers.max_import_bytes);
  }

  void EndOfFiles() {
    const bool queued = services_.executor.Post(
        [this] { Answer(Import(services_, context_, name_, dialect_, assembly_, *response_)); });
    if (!queued) Answer(absl::ResourceExhaustedError("too many calls are waiting: try again later"));
  }

  void Answer(const absl::Status& status) {
    status_ = status;
    Finish(ToGrpcStatus(status));
  }

  const Services& services_;
  const CallContext context_;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  v1::ImportMapResponse* const response_;
  v1::ImportMapRequest request_;
  bool begun_ = false;
  MapName name_;
  MapDialect dialect_ = MapDialect::kNav2;
  FileAssembly assembly_;
  absl::Status status_;
};

}  // namespace

grpc::ServerReadReactor<v1::ImportMapRequest>* ImportMap(const Services& services, grpc::CallbackServerContext* call,
                                                         v1::ImportMapResponse* response) {
  return new ImportMapReactor(services, call, response);
}

}  // namespace enfilade::server
