// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/map/import_map.h"

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
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
    if (manifest.dialect() == v1::MAP_DIALECT_ROS1) dialect_ = grid::MapDialect::kRos1;
    return assembly_.Begin(manifest.files(), services_.options.transfers.max_import_bytes);
  }

  absl::Status Answer(const storage::CallContext& context, v1::ImportMapResponse& response) {
    ENFILADE_ASSIGN_OR_RETURN(const std::vector<grid::MapFile> files, assembly_.Finish());
    ENFILADE_ASSIGN_OR_RETURN(const grid::ImportedMap imported, grid::ImportFiles(files, dialect_));
    for (const std::string& warning : imported.warnings) response.add_warnings(warning);
    ENFILADE_ASSIGN_OR_RETURN(RasterRevision raster, ToRevision(imported.raster));
    raster.revision.source = storage::RevisionSource::kImport;
    ENFILADE_RETURN_IF_ERROR(PutTiles(context, services_.blobs, name_.site, raster, {}));
    ENFILADE_ASSIGN_OR_RETURN(const storage::MapRevision revision,
                              services_.revisions.Add(context, name_.site, name_.map, raster.revision, {}));
    *response.mutable_revision() = ToProto(revision);
    // Who imports a map will look at it. If it cannot be made now, whoever looks first makes it, or is told why not.
    services_.raster_pyramids.Get(context, revision).IgnoreError();
    return absl::OkStatus();
  }

 private:
  const Services& services_;
  bool begun_ = false;
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
