// SPDX-License-Identifier: Apache-2.0
#include "server/app/exports/map_exports.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <optional>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "io/file.h"
#include "server/app/mapping/raster_revision.h"

namespace enfilade::server {
namespace {

namespace fs = std::filesystem;

constexpr char kDirectoryPrefix[] = "enfilade-cache-";

absl::Status WithDiskHint(const absl::Status& status) {
  if (!absl::IsResourceExhausted(status)) return status;
  return ResourceExhausted("{}: free space, or set transfers.cache_directory", std::string(status.message()));
}

void RemoveFiles(const std::vector<fs::path>& paths) {
  for (const fs::path& path : paths) unlink(path.c_str());
}

}  // namespace

ReadOnlyFile::~ReadOnlyFile() { close(descriptor_); }

absl::Status ReadOnlyFile::Read(std::int64_t offset, std::size_t size, char* out) const {
  while (size > 0) {
    const ssize_t n = pread(descriptor_, out, size, offset);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return DataLoss("a rendered map file is {} bytes too short", size);
    out += n;
    offset += n;
    size -= static_cast<std::size_t>(n);
  }
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<MapExports>> MapExports::Create(const ServerOptions::Transfers& options,
                                                               const storage::MapReader& maps,
                                                               const storage::RevisionStore& revisions) {
  std::error_code error;
  const fs::path parent =
      options.cache_directory.empty() ? fs::temp_directory_path(error) : fs::path(options.cache_directory);
  if (!error) fs::create_directories(parent, error);
  if (error) {
    return FailedPrecondition("transfers.cache_directory: cannot create {}: {}", parent.string(), error.message());
  }
  LockedDirectory::RemoveAbandoned(parent, kDirectoryPrefix);
  auto directory = LockedDirectory::Create(parent, kDirectoryPrefix);
  if (!directory.ok()) return WithContext(directory.status(), "transfers.cache_directory");
  return std::unique_ptr<MapExports>(new MapExports(options, maps, revisions, *std::move(directory)));
}

MapExports::MapExports(const ServerOptions::Transfers& options, const storage::MapReader& maps,
                       const storage::RevisionStore& revisions, LockedDirectory directory)
    : options_(options), maps_(maps), revisions_(revisions), directory_(std::move(directory)) {}

MapExports::~MapExports() = default;

absl::StatusOr<ExportedMap> MapExports::Get(const storage::CallContext& context, const convert::RevisionName& name,
                                            grid::MapFileFormat format) {
  ENFILADE_ASSIGN_OR_RETURN(const storage::Map map, maps_.Get(context, name.site, name.map));
  if (name.revision == 0 && map.current_revision == 0) {
    return FailedPrecondition("map \"{}\" has no revision yet: map a session into it, or import one", map.display_name);
  }
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapRevision revision,
                            revisions_.Get(context, name.site, name.map, name.revision));
  const std::string key = fmt::format("{}/{}/{}", ToHex(revision.content_sha256), static_cast<int>(format),
                                      grid::SafeStem(map.display_name));
  if (auto found = Find(key, revision)) return *std::move(found);
  MutexLock render_lock(render_mutex_);
  if (auto found = Find(key, revision)) return *std::move(found);  // another call has rendered it
  ENFILADE_ASSIGN_OR_RETURN(Entry entry, Render(context, revision, map.display_name, format));
  entry.key = key;
  ExportedMap rendered = entry.map;
  MutexLock lock(mutex_);
  bytes_ += entry.bytes;
  entries_.push_front(std::move(entry));
  Evict();
  return rendered;
}

std::optional<ExportedMap> MapExports::Find(const std::string& key, const storage::MapRevision& revision) {
  MutexLock lock(mutex_);
  for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
    if (entry->key != key) continue;
    entries_.splice(entries_.begin(), entries_, entry);
    ExportedMap found = entries_.front().map;
    found.revision = revision;
    return found;
  }
  return std::nullopt;
}

absl::StatusOr<MapExports::Entry> MapExports::Render(const storage::CallContext& context,
                                                     const storage::MapRevision& revision,
                                                     const std::string& display_name, grid::MapFileFormat format) {
  ENFILADE_ASSIGN_OR_RETURN(const grid::MapRaster raster, ReadRaster(context, revisions_, revision));
  grid::MapFileOptions file_options;
  file_options.format = format;
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<grid::MapFile> files,
                            grid::RenderFiles(raster, display_name, file_options));
  Entry entry;
  entry.map.revision = revision;
  for (const grid::MapFile& file : files) {
    const absl::Status status = Add(file, entry);
    if (status.ok()) continue;
    RemoveFiles(entry.paths);
    return status;
  }
  return entry;
}

absl::Status MapExports::Add(const grid::MapFile& file, Entry& entry) {
  const fs::path path = directory_.path() / std::to_string(next_file_++);
  entry.paths.push_back(path);
  ENFILADE_RETURN_IF_ERROR(WithDiskHint(io::WriteFile(path, file.bytes)));
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return io::FileError(path, "cannot be opened", errno);
  const auto size = static_cast<std::int64_t>(file.bytes.size());
  entry.bytes += size;
  entry.map.files.push_back({file.name, size, Sha256(file.bytes), std::make_shared<const ReadOnlyFile>(descriptor)});
  return absl::OkStatus();
}

// Keeps the newest entry, however large it is.
void MapExports::Evict() {
  while (bytes_ > options_.cache_bytes && entries_.size() > 1) {
    RemoveFiles(entries_.back().paths);
    bytes_ -= entries_.back().bytes;
    entries_.pop_back();
  }
}

}  // namespace enfilade::server
