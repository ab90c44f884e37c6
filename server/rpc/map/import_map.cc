// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/map/import_map.h"

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/app/edits/edited_revision.h"
#include "server/app/mapping/raster_revision.h"
#include "server/rpc/call/client_stream.h"
#include "server/rpc/map/file_assembly.h"
#include "server/rpc/resources.h"

namespace enfilade::server {
namespace {

class MapImporter {
 public:
  explicit MapImporter(const Services& services) : services_(services), assembly_(services.uploads) {}

  absl::Status Take(const v1::ImportMapRequest& request) {
    if (request.has_chunk()) return assembly_.Add(request.chunk());
    if (!request.has_manifest() || begun_) {
      return InvalidArgument("expected the manifest as the first message, and chunks after it");
    }
    begun_ = true;
    const v1::ImportMapManifest& manifest = request.manifest();
    ENFILADE_ASSIGN_OR_RETURN(name_, convert::ParseMapName("manifest.parent", manifest.parent()));
    if (!v1::MapDialect_IsValid(manifest.dialect())) {
      return InvalidArgument("manifest.dialect is {}: unknown to this server", static_cast<int>(manifest.dialect()));
    }
    keep_edits_ = manifest.keep_edits();
    if (manifest.dialect() == v1::MAP_DIALECT_ROS1) dialect_ = grid::MapDialect::kRos1;
    return assembly_.Begin(manifest.files(), services_.options.transfers.max_import_bytes);
  }

  absl::Status Answer(const storage::CallContext& context, v1::ImportMapResponse& response) {
    ENFILADE_ASSIGN_OR_RETURN(const std::vector<grid::MapFile> files, assembly_.Finish());
    ENFILADE_ASSIGN_OR_RETURN(const grid::ImportedMap imported, grid::ImportFiles(files, dialect_));
    for (const std::string& warning : imported.warnings) response.add_warnings(warning);
    ENFILADE_ASSIGN_OR_RETURN(const storage::MapRevision revision, Store(context, imported.raster));
    *response.mutable_revision() = ToProto(revision);
    // Who imports a map will look at it. If it cannot be made now, whoever looks first makes it, or is told why not.
    services_.raster_pyramids.Get(context, revision).IgnoreError();
    return absl::OkStatus();
  }

 private:
  // Whoever publishes meanwhile has the edits laid over the files once more.
  absl::StatusOr<storage::MapRevision> Store(const storage::CallContext& context, const grid::MapRaster& raster) {
    absl::StatusOr<storage::MapRevision> revision = absl::UnknownError("");
    for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
      storage::OverlayState state;
      if (keep_edits_) {
        ENFILADE_ASSIGN_OR_RETURN(state, services_.map_edit_store.ReadOverlay(context, name_.site, name_.map));
      }
      ENFILADE_ASSIGN_OR_RETURN(RasterRevision whole, StoreEdited(context, {services_.blobs, services_.revisions},
                                                                  {name_.site, name_.map}, state.overlay, raster, {}));
      whole.revision.source = storage::RevisionSource::kImport;
      if (keep_edits_) whole.revision.layers_version = state.layers_version;
      revision = services_.revisions.Add(context, name_.site, name_.map, whole.revision, {});
      if (!storage::AreLayersChanged(revision.status())) return revision;
    }
    return revision;
  }

  static constexpr int kMaxAttempts = 100;

  const Services& services_;
  bool begun_ = false;
  bool keep_edits_ = false;
  convert::MapName name_;
  grid::MapDialect dialect_ = grid::MapDialect::kNav2;
  FileAssembly assembly_;
};

}  // namespace

grpc::ServerReadReactor<v1::ImportMapRequest>* ImportMap(const Services& services, const CallEntry& entry,
                                                         v1::ImportMapResponse* response) {
  return RunClientStream<MapImporter, v1::ImportMapRequest>(entry, response,
                                                            [&services] { return MapImporter(services); });
}

}  // namespace enfilade::server
