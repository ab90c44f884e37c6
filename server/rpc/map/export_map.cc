// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/map/export_map.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/map_service.pb.h"
#include "proto/convert/names.h"
#include "server/rpc/map/chunk_message.h"
#include "server/rpc/map/named_revision.h"
#include "server/rpc/resources.h"

namespace enfilade::server {
namespace {

constexpr std::int64_t kChunkBytes = 1 << 20;

absl::StatusOr<grid::MapFileFormat> FormatOf(v1::MapFormat format) {
  switch (format) {
    case v1::MAP_FORMAT_PGM:
      return grid::MapFileFormat::kPgm;
    case v1::MAP_FORMAT_PNG:
      return grid::MapFileFormat::kPng;
    case v1::MAP_FORMAT_JSON:
      return grid::MapFileFormat::kJson;
    default:
      return InvalidArgument("format is {}: expected MAP_FORMAT_PGM, _PNG or _JSON", static_cast<int>(format));
  }
}

// The manifest first, then the files chunk by chunk.
class ExportSource {
 public:
  explicit ExportSource(ExportedMap map) : map_(std::move(map)) {}

  absl::StatusOr<bool> operator()(grpc::ByteBuffer& message) {
    if (!std::exchange(manifest_sent_, true)) {
      ENFILADE_ASSIGN_OR_RETURN(message, EncodeManifest());
      return true;
    }
    while (file_ < map_.files.size() && offset_ == map_.files[file_].size) {
      ++file_;
      offset_ = 0;
    }
    if (file_ == map_.files.size()) return false;
    const ExportedFile& file = map_.files[file_];
    const auto size = static_cast<std::size_t>(std::min(kChunkBytes, file.size - offset_));
    const auto read = [&](char* data) { return file.content->Read(offset_, size, data); };
    ENFILADE_ASSIGN_OR_RETURN(message, EncodeChunkMessage(static_cast<std::int32_t>(file_), offset_, size, read));
    offset_ += static_cast<std::int64_t>(size);
    return true;
  }

 private:
  absl::StatusOr<grpc::ByteBuffer> EncodeManifest() const {
    v1::ExportMapResponse message;
    v1::ExportMapManifest& manifest = *message.mutable_manifest();
    *manifest.mutable_revision() = ToProto(map_.revision);
    for (const ExportedFile& file : map_.files) {
      v1::FileEntry& entry = *manifest.add_files();
      entry.set_name(file.name);
      entry.set_size_bytes(file.size);
      entry.set_sha256(file.sha256);
    }
    const grpc::Slice bytes(message.SerializeAsString());
    return grpc::ByteBuffer(&bytes, 1);
  }

  ExportedMap map_;
  bool manifest_sent_ = false;
  std::size_t file_ = 0;
  std::int64_t offset_ = 0;
};

}  // namespace

void ExportMap(const Services& services, const Call& call, const v1::ExportMapRequest& request,
               Opened<grpc::ByteBuffer> opened) {
  const absl::StatusOr<convert::RevisionName> name =
      ResolveMapOrRevision(services, call.context(), "name", request.name());
  if (!name.ok()) return opened(name.status());
  const absl::StatusOr<grid::MapFileFormat> format = FormatOf(request.format());
  if (!format.ok()) return opened(format.status());
  if (request.without_edits() && name->revision != 0) {
    return opened(InvalidArgument(
        "without_edits is set and name is {}: only the newest revision has both; name the map", request.name()));
  }
  services.exports.Get(call.context(), {*name, *format, request.without_edits()},
                       [&call, opened = std::move(opened)](absl::StatusOr<ExportedMap> map) {
                         call.Continue([opened, map = std::move(map)] {
                           if (!map.ok()) return opened(map.status());
                           opened(MessageSource<grpc::ByteBuffer>(ExportSource(*map)));
                         });
                       });
}

}  // namespace enfilade::server
