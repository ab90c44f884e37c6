// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/api/map_export.h"

#include <utility>

#include "client/sdk/api/file_download.h"
#include "client/sdk/api/file_folder.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/map_service.grpc.pb.h"

namespace enfilade::client {

absl::StatusOr<DownloadedMap> DownloadMap(const Connection& connection, const v1::ExportMapRequest& request,
                                          const TransferProgress& progress) {
  DownloadedMap map;
  const auto start = [&](const v1::ExportMapManifest& manifest) {
    map.revision = manifest.revision();
    for (const v1::FileEntry& file : manifest.files()) map.files.push_back({file.name(), ""});
    return absl::OkStatus();
  };
  const auto take = [&](const v1::FileChunk& chunk) {
    map.files[static_cast<std::size_t>(chunk.file())].bytes += chunk.data();
    return absl::OkStatus();
  };
  v1::MapService::Stub stub(connection.channel());
  grpc::ClientContext context;
  connection.SetActor(context);
  ENFILADE_RETURN_IF_ERROR(ReceiveFiles(connection, context, stub.ExportMap(&context, request),
                                        FileSink<decltype(start), decltype(take)>{start, take, progress}));
  return map;
}

absl::StatusOr<ExportedMap> ExportMap(const Connection& connection, const v1::ExportMapRequest& request,
                                      const std::filesystem::path& folder, const TransferProgress& progress) {
  ENFILADE_RETURN_IF_ERROR(CreateFolder(folder));
  v1::MapService::Stub stub(connection.channel());
  grpc::ClientContext context;
  connection.SetActor(context);
  ExportedMap map;
  const auto note = [&](const v1::ExportMapManifest& manifest) { map.revision = manifest.revision(); };
  ENFILADE_ASSIGN_OR_RETURN(SavedFiles saved,
                            SaveFiles(connection, context, stub.ExportMap(&context, request), folder, note, progress));
  map.files = std::move(saved.files);
  map.bytes = saved.bytes;
  return map;
}

}  // namespace enfilade::client
