// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "core/grid/files/map_files.h"
#include "proto/convert/names.h"
#include "server/app/edits/edited_revision.h"
#include "server/app/exports/locked_directory.h"
#include "server/app/runtime/executor.h"
#include "server/config/server_options.h"
#include "storage/maps/map_store.h"
#include "storage/maps/revision_store.h"

namespace enfilade::server {

// A file of the cache, which is removed with the last reference to it. Not kept open: the number of files in the cache
// has no limit, that of open files has one. Thread-safe.
class RenderedFile {
 public:
  explicit RenderedFile(std::filesystem::path path) : path_(std::move(path)) {}
  // Removes the file.
  ~RenderedFile();
  RenderedFile(const RenderedFile&) = delete;
  RenderedFile& operator=(const RenderedFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  // Reads exactly `size` bytes from `offset` into `out`. DATA_LOSS if the file is too short; NOT_FOUND if somebody else
  // has removed it; other errors as io::FileError.
  absl::Status Read(std::int64_t offset, std::size_t size, char* out) const;

 private:
  const std::filesystem::path path_;
};

struct ExportedFile {
  std::string name;
  std::int64_t size = 0;
  std::string sha256;
  std::shared_ptr<const RenderedFile> content;
};

struct ExportedMap {
  storage::MapRevision revision;
  std::vector<ExportedFile> files;
};

// Renders revisions as files and caches them on disk for the next download: rendering a large map takes longer than
// sending it. Two threads render, one of them large maps only and one the others, to bound the memory of concurrent
// requests. However many want the same files, they are rendered once. Thread-safe.
class MapExports {
 public:
  using Done = std::function<void(absl::StatusOr<ExportedMap>)>;

  // FAILED_PRECONDITION naming the folder if it cannot be created. Removes the folders of killed servers.
  static absl::StatusOr<std::unique_ptr<MapExports>> Create(const ServerOptions::Transfers& options,
                                                            const storage::MapReader& maps,
                                                            const RasterStores& rasters);
  // Removes the cache.
  ~MapExports();

  struct Wanted {
    convert::RevisionName name;
    grid::MapFileFormat format = grid::MapFileFormat::kPgm;
    bool without_edits = false;  // of the newest revision only
  };
  // Reads what is to be exported, and calls `done` with its files: in this thread if they are cached or there is an
  // error, else in one that renders. `done` must not wait. Rendering takes as long as it takes, but ends when all who
  // want it have cancelled. NOT_FOUND; FAILED_PRECONDITION if the map has no revision yet; RESOURCE_EXHAUSTED if the
  // disk is full or too many wait.
  void Get(const storage::CallContext& context, const Wanted& wanted, Done done);

 private:
  // What is exported, and the name under which it is cached.
  struct Subject {
    storage::MapRevision revision;
    std::string display_name;
    grid::MapFileFormat format = grid::MapFileFormat::kPgm;
    bool without_edits = false;
    std::string key;
  };
  struct Waiter;
  struct Rendering;
  struct Entry {
    std::string key;
    ExportedMap map;
    std::int64_t bytes = 0;
  };

  MapExports(const ServerOptions::Transfers& options, const storage::MapReader& maps, const RasterStores& rasters,
             LockedDirectory directory);
  absl::StatusOr<Subject> FindSubject(const storage::CallContext& context, const Wanted& wanted) const;
  void Wait(const Subject& subject, Waiter waiter);
  void Run(const std::shared_ptr<Rendering>& rendering);
  // Moves the entry to the front; the result has `revision`, which may be another one with the same content.
  std::optional<ExportedMap> Find(const std::string& key, const storage::MapRevision& revision)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::StatusOr<Entry> Render(const storage::CallContext& context, const Subject& subject);
  absl::Status Add(const grid::MapFile& file, Entry& entry);
  void Evict() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const ServerOptions::Transfers options_;
  const storage::MapReader& maps_;
  const RasterStores rasters_;
  const LockedDirectory directory_;

  Mutex mutex_;
  std::list<Entry> entries_ ABSL_GUARDED_BY(mutex_);  // most recently used first
  std::int64_t bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  std::map<std::string, std::shared_ptr<Rendering>> renderings_ ABSL_GUARDED_BY(mutex_);  // by key
  std::size_t waiting_ ABSL_GUARDED_BY(mutex_) = 0;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::atomic<std::int64_t> next_file_ = 0;
  Executor renderer_;
  Executor renderer_of_large_maps_;
};

}  // namespace enfilade::server
