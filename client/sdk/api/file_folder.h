// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/sdk/api/file_download.h"
#include "core/base/status_macros.h"

namespace enfilade::client {

// INVALID_ARGUMENT: the folder cannot be created.
absl::Status CreateFolder(const std::filesystem::path& folder);

// Files of a download on disk, each under a temporary name until Commit. What is not committed is removed.
class PartFiles {
 public:
  explicit PartFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}
  ~PartFiles();
  PartFiles(const PartFiles&) = delete;
  PartFiles& operator=(const PartFiles&) = delete;

  // Only the last segment of a name counts: no server writes outside of the folder.
  void Start(const google::protobuf::RepeatedPtrField<v1::FileEntry>& files);
  // INVALID_ARGUMENT: the file cannot be created; RESOURCE_EXHAUSTED: the disk is full.
  absl::Status Write(const v1::FileChunk& chunk);
  // The files, under their names.
  absl::StatusOr<std::vector<std::filesystem::path>> Commit();

 private:
  const std::filesystem::path folder_;
  std::vector<std::filesystem::path> paths_;
  std::ofstream out_;
};

struct SavedFiles {
  std::vector<std::filesystem::path> files;
  std::int64_t bytes = 0;  // of all files
};

// As ReceiveFiles, into files in `folder`, which exists. `note(manifest)` is called once. A file gets its name once all
// of them are complete and checked. Errors as ReceiveFiles and PartFiles.
template <typename Response, typename Note>
absl::StatusOr<SavedFiles> SaveFiles(const Connection& connection, grpc::ClientContext& context,
                                     std::unique_ptr<grpc::ClientReader<Response>> reader,
                                     const std::filesystem::path& folder, const Note& note,
                                     const TransferProgress& progress) {
  SavedFiles saved;
  PartFiles parts(folder);
  const auto start = [&](const auto& manifest) {
    note(manifest);
    for (const v1::FileEntry& file : manifest.files()) saved.bytes += file.size_bytes();
    parts.Start(manifest.files());
    return absl::OkStatus();
  };
  const auto take = [&](const v1::FileChunk& chunk) { return parts.Write(chunk); };
  ENFILADE_RETURN_IF_ERROR(ReceiveFiles(connection, context, std::move(reader),
                                        FileSink<decltype(start), decltype(take)>{start, take, progress}));
  ENFILADE_ASSIGN_OR_RETURN(saved.files, parts.Commit());
  return saved;
}

}  // namespace enfilade::client
