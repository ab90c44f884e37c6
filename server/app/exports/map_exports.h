// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "core/grid/files/map_files.h"
#include "proto/convert/names.h"
#include "server/app/exports/locked_directory.h"
#include "server/config/server_options.h"
#include "storage/maps/map_store.h"
#include "storage/maps/revision_store.h"

namespace enfilade::server {

// An open file. Readers are not affected when the file is unlinked. Thread-safe.
class ReadOnlyFile {
 public:
  explicit ReadOnlyFile(int descriptor) : descriptor_(descriptor) {}
  ~ReadOnlyFile();
  ReadOnlyFile(const ReadOnlyFile&) = delete;
  ReadOnlyFile& operator=(const ReadOnlyFile&) = delete;

  // Reads exactly `size` bytes from `offset` into `out`. DATA_LOSS if the file is too short.
  absl::Status Read(std::int64_t offset, std::size_t size, char* out) const;

 private:
  const int descriptor_;
};

struct ExportedFile {
  std::string name;
  std::int64_t size = 0;
  std::string sha256;
  std::shared_ptr<const ReadOnlyFile> content;
};

struct ExportedMap {
  storage::MapRevision revision;
  std::vector<ExportedFile> files;
};

// Renders revisions as files and caches them on disk for the next download: rendering a large map takes longer than
// sending it. Renders one revision at a time to bound the memory of concurrent requests. Thread-safe.
class MapExports {
 public:
  // FAILED_PRECONDITION naming the folder if it cannot be created. Removes the folders of killed servers.
  static absl::StatusOr<std::unique_ptr<MapExports>> Create(const ServerOptions::Transfers& options,
                                                            const storage::MapReader& maps,
                                                            const storage::RevisionStore& revisions);
  // Removes the cache.
  ~MapExports();

  // NOT_FOUND; FAILED_PRECONDITION if the map has no revision yet; RESOURCE_EXHAUSTED if the disk is full.
  absl::StatusOr<ExportedMap> Get(const storage::CallContext& context, const convert::RevisionName& name,
                                  grid::MapFileFormat format);

 private:
  struct Entry {
    std::string key;
    ExportedMap map;
    std::vector<std::filesystem::path> paths;
    std::int64_t bytes = 0;
  };

  MapExports(const ServerOptions::Transfers& options, const storage::MapReader& maps,
             const storage::RevisionStore& revisions, LockedDirectory directory);
  // Moves the entry to the front; the result has `revision`, which may be another one with the same content.
  std::optional<ExportedMap> Find(const std::string& key, const storage::MapRevision& revision);
  absl::StatusOr<Entry> Render(const storage::CallContext& context, const storage::MapRevision& revision,
                               const std::string& display_name, grid::MapFileFormat format)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(render_mutex_);
  absl::Status Add(const grid::MapFile& file, Entry& entry) ABSL_EXCLUSIVE_LOCKS_REQUIRED(render_mutex_);
  void Evict() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const ServerOptions::Transfers options_;
  const storage::MapReader& maps_;
  const storage::RevisionStore& revisions_;
  const LockedDirectory directory_;

  Mutex render_mutex_ ABSL_ACQUIRED_BEFORE(mutex_);
  Mutex mutex_;
  std::list<Entry> entries_ ABSL_GUARDED_BY(mutex_);  // most recently used first
  std::int64_t bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  std::int64_t next_file_ ABSL_GUARDED_BY(render_mutex_) = 0;
};

}  // namespace enfilade::server
