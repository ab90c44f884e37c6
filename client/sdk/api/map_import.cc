// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/api/map_import.h"

#include "client/sdk/api/file_upload.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/map_service.grpc.pb.h"

namespace enfilade::client {

absl::StatusOr<v1::ImportMapResponse> ImportMap(const Connection& connection, const std::string& map,
                                                v1::MapDialect dialect, absl::Span<const NamedFile> files,
                                                const TransferProgress& progress, bool keep_edits) {
  v1::ImportMapRequest message;
  message.mutable_manifest()->set_parent(map);
  message.mutable_manifest()->set_dialect(dialect);
  message.mutable_manifest()->set_keep_edits(keep_edits);
  for (const NamedFile& file : files) *message.mutable_manifest()->add_files() = EntryOf(file);
  v1::MapService::Stub stub(connection.channel());
  grpc::ClientContext context;
  connection.SetActor(context);
  v1::ImportMapResponse response;
  const auto writer = stub.ImportMap(&context, &response);
  ENFILADE_RETURN_IF_ERROR(SendFiles(connection, *writer, message, files, progress));
  return response;
}

}  // namespace enfilade::client
