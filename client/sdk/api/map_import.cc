// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/api/map_import.h"

#include <cstdint>
#include <string_view>

#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/map_service.grpc.pb.h"

namespace enfilade::client {
namespace {

v1::ImportMapRequest ManifestOf(const std::string& map, v1::MapDialect dialect, absl::Span<const NamedFile> files) {
  v1::ImportMapRequest message;
  message.mutable_manifest()->set_parent(map);
  message.mutable_manifest()->set_dialect(dialect);
  for (const NamedFile& file : files) {
    v1::FileEntry& entry = *message.mutable_manifest()->add_files();
    entry.set_name(file.name);
    entry.set_size_bytes(static_cast<std::int64_t>(file.bytes.size()));
    entry.set_sha256(Sha256(file.bytes));
  }
  return message;
}

}  // namespace

absl::StatusOr<v1::ImportMapResponse> ImportMap(const Connection& connection, const std::string& map,
                                                v1::MapDialect dialect, absl::Span<const NamedFile> files,
                                                const TransferProgress& progress) {
  std::int64_t total = 0;
  for (const NamedFile& file : files) total += static_cast<std::int64_t>(file.bytes.size());
  v1::MapService::Stub stub(connection.channel());
  grpc::ClientContext context;
  connection.SetActor(context);
  v1::ImportMapResponse response;
  const auto writer = stub.ImportMap(&context, &response);
  bool open = writer->Write(ManifestOf(map, dialect, files));
  std::int64_t sent = 0;
  for (std::size_t i = 0; open && i < files.size(); ++i) {
    open = ForEachChunk(files[i].bytes, [&](std::int64_t offset, std::string_view data) {
      v1::ImportMapRequest message;
      v1::FileChunk& chunk = *message.mutable_chunk();
      chunk.set_file(static_cast<std::int32_t>(i));
      chunk.set_offset(offset);
      chunk.set_data(std::string(data));
      if (!writer->Write(message)) return false;
      sent += static_cast<std::int64_t>(data.size());
      if (progress) progress(sent, total);
      return true;
    });
  }
  writer->WritesDone();  // if the server has ended the call, Finish has the reason
  ENFILADE_RETURN_IF_ERROR(FromGrpcStatus(writer->Finish(), connection.address()));
  return response;
}

}  // namespace enfilade::client
