// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/api/map_export.h"

#include <fstream>
#include <system_error>
#include <utility>

#include "client/sdk/api/file_download.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/map_service.grpc.pb.h"

namespace enfilade::client {
namespace {

namespace fs = std::filesystem;

// Files of a download on disk, each under a temporary name until Commit.
class PartFiles {
 public:
  explicit PartFiles(fs::path folder) : folder_(std::move(folder)) {}
  ~PartFiles() {
    std::error_code ignored;
    for (const fs::path& path : paths_) fs::remove(PartOf(path), ignored);
  }
  PartFiles(const PartFiles&) = delete;
  PartFiles& operator=(const PartFiles&) = delete;

  // Only the last segment of a name counts: no server writes outside of the folder.
  void Start(const google::protobuf::RepeatedPtrField<v1::FileEntry>& files) {
    for (const v1::FileEntry& file : files) paths_.push_back(folder_ / fs::path(file.name()).filename());
  }

  absl::Status Write(const v1::FileChunk& chunk) {
    const fs::path part = PartOf(paths_[static_cast<std::size_t>(chunk.file())]);
    if (chunk.offset() == 0) {
      out_ = std::ofstream(part, std::ios::binary | std::ios::trunc);
      if (!out_) return InvalidArgument("{}: cannot be written", part.string());
    }
    out_.write(chunk.data().data(), static_cast<std::streamsize>(chunk.data().size()));
    if (out_.flush()) return absl::OkStatus();
    return ResourceExhausted("{}: cannot be written: is the disk full?", folder_.string());
  }

  absl::StatusOr<std::vector<fs::path>> Commit() {
    out_.close();
    for (const fs::path& path : paths_) {
      std::error_code error;
      if (!fs::exists(PartOf(path), error)) std::ofstream(PartOf(path), std::ios::binary);  // an empty file: no chunks
      fs::rename(PartOf(path), path, error);
      if (error) return InvalidArgument("{}: cannot be written: {}", path.string(), error.message());
    }
    return paths_;
  }

 private:
  static fs::path PartOf(const fs::path& path) { return path.string() + ".part"; }

  const fs::path folder_;
  std::vector<fs::path> paths_;
  std::ofstream out_;
};

// `start` gets the manifest, `take` every chunk.
template <typename Start, typename Take>
absl::Status ReceiveMap(const Connection& connection, const v1::ExportMapRequest& request, const Start& start,
                        const Take& take, const TransferProgress& progress) {
  v1::MapService::Stub stub(connection.channel());
  grpc::ClientContext context;
  connection.SetActor(context);
  return ReceiveFiles(connection, context, stub.ExportMap(&context, request),
                      FileSink<Start, Take>{start, take, progress});
}

}  // namespace

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
  ENFILADE_RETURN_IF_ERROR(ReceiveMap(connection, request, start, take, progress));
  return map;
}

absl::StatusOr<ExportedMap> ExportMap(const Connection& connection, const v1::ExportMapRequest& request,
                                      const fs::path& folder, const TransferProgress& progress) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return InvalidArgument("{}: the folder cannot be created: {}", folder.string(), error.message());
  ExportedMap map;
  PartFiles files(folder);
  const auto start = [&](const v1::ExportMapManifest& manifest) {
    map.revision = manifest.revision();
    for (const v1::FileEntry& file : manifest.files()) map.bytes += file.size_bytes();
    files.Start(manifest.files());
    return absl::OkStatus();
  };
  const auto take = [&](const v1::FileChunk& chunk) { return files.Write(chunk); };
  ENFILADE_RETURN_IF_ERROR(ReceiveMap(connection, request, start, take, progress));
  ENFILADE_ASSIGN_OR_RETURN(map.files, files.Commit());
  return map;
}

}  // namespace enfilade::client
