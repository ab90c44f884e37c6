// SPDX-License-Identifier: Apache-2.0
#include "server/app/exports/map_exports.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <optional>
#include <stop_token>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "io/file.h"
#include "server/app/mapping/raster_revision.h"

namespace enfilade::server {
namespace {

namespace fs = std::filesystem;

constexpr char kDirectoryPrefix[] = "enfilade-cache-";
constexpr std::size_t kMaxWaiting = 1000;
// Cells beyond which a map is large: 16 Mpx are rendered in half a second.
constexpr std::int64_t kLargeMap = 16 << 20;
// Of rendering, which keeps a processor busy for seconds.
constexpr int kNiceness = 10;
constexpr auto kRenderTimeout = std::chrono::minutes(10);

absl::Status WithDiskHint(const absl::Status& status) {
  if (!absl::IsResourceExhausted(status)) return status;
  return ResourceExhausted("{}: free space, or set transfers.cache_directory", std::string(status.message()));
}

}  // namespace

RenderedFile::~RenderedFile() { unlink(path_.c_str()); }

// Opens the file for each chunk (1 MiB), which is cheap beside sending it.
absl::Status RenderedFile::Read(std::int64_t offset, std::size_t size, char* out) const {
  const int descriptor = open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return io::FileError(path_, "cannot be opened", errno);
  ssize_t n = 0;
  while (size > 0) {
    n = pread(descriptor, out, size, offset);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    out += n;
    offset += n;
    size -= static_cast<std::size_t>(n);
  }
  const int error = errno;
  close(descriptor);
  if (n < 0) return io::FileError(path_, "cannot be read", error);
  if (size > 0) return DataLoss("a rendered map file is {} bytes too short", size);
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<MapExports>> MapExports::Create(const ServerOptions::Transfers& options,
                                                               const storage::MapReader& maps,
                                                               const RasterStores& rasters) {
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
  return std::unique_ptr<MapExports>(new MapExports(options, maps, rasters, *std::move(directory)));
}

struct MapExports::Rendering {
  explicit Rendering(Subject given) : subject(std::move(given)) {}

  // Called for each waiter that has cancelled.
  void Leave() {
    if (--wanted == 0) abandoned.request_stop();
  }

  const Subject subject;
  std::atomic<int> wanted = 0;
  std::stop_source abandoned;
  std::vector<Waiter> waiters;  // guarded by MapExports::mutex_
};

struct MapExports::Waiter {
  std::stop_token cancellation;
  storage::MapRevision revision;  // may be another one with the same content
  Done done;
  std::unique_ptr<std::stop_callback<std::function<void()>>> on_cancel = nullptr;
};

MapExports::MapExports(const ServerOptions::Transfers& options, const storage::MapReader& maps,
                       const RasterStores& rasters, LockedDirectory directory)
    : options_(options),
      maps_(maps),
      rasters_(rasters),
      directory_(std::move(directory)),
      renderer_(1, kMaxWaiting, kNiceness),
      renderer_of_large_maps_(1, kMaxWaiting, kNiceness) {}

MapExports::~MapExports() {
  {
    MutexLock lock(mutex_);
    stopping_ = true;
    for (const auto& [key, rendering] : renderings_) rendering->abandoned.request_stop();
  }
  renderer_.Stop();
  renderer_of_large_maps_.Stop();
}

absl::StatusOr<MapExports::Subject> MapExports::FindSubject(const storage::CallContext& context,
                                                            const Wanted& wanted) const {
  const convert::RevisionName& name = wanted.name;
  ENFILADE_ASSIGN_OR_RETURN(const storage::Map map, maps_.Get(context, name.site, name.map));
  if (name.revision == 0 && map.current_revision == 0) {
    return FailedPrecondition("map \"{}\" has no revision yet: map a session into it, or import one", map.display_name);
  }
  Subject subject{.revision = {},
                  .display_name = map.display_name,
                  .format = wanted.format,
                  .without_edits = wanted.without_edits,
                  .key = {}};
  ENFILADE_ASSIGN_OR_RETURN(subject.revision, rasters_.revisions.Get(context, name.site, name.map, name.revision));
  subject.key = fmt::format("{}/{}/{}", ToHex(subject.revision.content_sha256), static_cast<int>(wanted.format),
                            grid::SafeStem(map.display_name));
  if (wanted.without_edits) {
    subject.key += fmt::format("/evidence of {} {} of {}", NameOf(name.site, subject.revision.map),
                               subject.revision.number, subject.revision.create_time);
  }
  return subject;
}

void MapExports::Get(const storage::CallContext& context, const Wanted& wanted, Done done) {
  const absl::StatusOr<Subject> subject = FindSubject(context, wanted);
  if (!subject.ok()) return done(subject.status());
  Wait(*subject, {.cancellation = context.cancellation, .revision = subject->revision, .done = std::move(done)});
}

void MapExports::Wait(const Subject& subject, Waiter waiter) {
  std::shared_ptr<Rendering> rendering;
  absl::StatusOr<ExportedMap> now = ResourceExhausted("too many exports are waiting: try again later");
  bool begin = false;
  {
    MutexLock lock(mutex_);
    if (auto found = Find(subject.key, waiter.revision)) {
      now = *std::move(found);
    } else if (stopping_) {
      now = absl::CancelledError("the server is shutting down");
    } else if (waiting_ < kMaxWaiting) {
      ++waiting_;
      std::shared_ptr<Rendering>& current = renderings_[subject.key];
      begin = current == nullptr;
      if (begin) current = std::make_shared<Rendering>(subject);
      rendering = current;
      ++rendering->wanted;
      waiter.on_cancel = std::make_unique<std::stop_callback<std::function<void()>>>(
          waiter.cancellation, [rendering] { rendering->Leave(); });
      rendering->waiters.push_back(std::move(waiter));
    }
  }
  if (rendering == nullptr) return waiter.done(std::move(now));
  if (!begin) return;
  const grid::GridGeometry& geometry = subject.revision.geometry;
  const bool large = std::int64_t{geometry.width} * geometry.height > kLargeMap;
  (large ? renderer_of_large_maps_ : renderer_).PostNext([this, rendering] { Run(rendering); });
}

void MapExports::Run(const std::shared_ptr<Rendering>& rendering) {
  const Subject& subject = rendering->subject;
  absl::StatusOr<Entry> entry = absl::CancelledError("nobody waits for the export");
  if (!rendering->abandoned.stop_requested()) {
    storage::CallContext context = storage::CallContext::WithTimeout(kRenderTimeout);
    context.cancellation = rendering->abandoned.get_token();
    entry = Render(context, subject);
  }
  std::vector<Waiter> waiters;
  absl::StatusOr<ExportedMap> rendered = absl::UnknownError("");
  {
    MutexLock lock(mutex_);
    renderings_.erase(subject.key);
    waiters.swap(rendering->waiters);
    waiting_ -= waiters.size();
    if (!entry.ok()) {
      rendered = entry.status();
    } else {
      rendered = entry->map;
      // Of a newer revision than was asked for: nobody asks for it by this key again.
      if (entry->map.revision.number == subject.revision.number) entry->key = subject.key;
      bytes_ += entry->bytes;
      entries_.push_front(*std::move(entry));
      Evict();
    }
  }
  for (Waiter& waiter : waiters) {
    waiter.on_cancel.reset();
    // It came after the others had gone.
    const bool again = absl::IsCancelled(rendered.status()) && !waiter.cancellation.stop_requested();
    if (again) {
      Wait(subject, std::move(waiter));
      continue;
    }
    if (rendered.ok() && !subject.without_edits) rendered->revision = waiter.revision;
    waiter.done(rendered);
  }
}

std::optional<ExportedMap> MapExports::Find(const std::string& key, const storage::MapRevision& revision) {
  for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
    if (entry->key != key) continue;
    entries_.splice(entries_.begin(), entries_, entry);
    ExportedMap found = entries_.front().map;
    found.revision = revision;
    return found;
  }
  return std::nullopt;
}

absl::StatusOr<MapExports::Entry> MapExports::Render(const storage::CallContext& context, const Subject& subject) {
  storage::MapRevision revision = subject.revision;
  absl::StatusOr<grid::MapRaster> raster = subject.without_edits ? ReadEvidence(context, rasters_, revision)
                                                                 : ReadRaster(context, rasters_.revisions, revision);
  ENFILADE_RETURN_IF_ERROR(raster.status());
  // What is below the edits is stored of the newest revision only: it may be that of a newer one.
  while (subject.without_edits) {
    ENFILADE_ASSIGN_OR_RETURN(storage::MapRevision newest,
                              rasters_.revisions.Get(context, revision.site, revision.map, 0));
    if (newest.number == revision.number) break;
    revision = std::move(newest);
    raster = ReadEvidence(context, rasters_, revision);
    ENFILADE_RETURN_IF_ERROR(raster.status());
  }
  grid::MapFileOptions file_options;
  file_options.format = subject.format;
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<grid::MapFile> files,
                            grid::RenderFiles(*raster, subject.display_name, file_options));
  Entry entry;
  entry.map.revision = revision;
  for (const grid::MapFile& file : files) ENFILADE_RETURN_IF_ERROR(Add(file, entry));
  return entry;
}

absl::Status MapExports::Add(const grid::MapFile& file, Entry& entry) {
  const auto content = std::make_shared<const RenderedFile>(directory_.path() / std::to_string(next_file_++));
  ENFILADE_RETURN_IF_ERROR(WithDiskHint(io::WriteFile(content->path(), file.bytes)));
  const auto size = static_cast<std::int64_t>(file.bytes.size());
  entry.bytes += size;
  entry.map.files.push_back({file.name, size, Sha256(file.bytes), content});
  return absl::OkStatus();
}

// Keeps the newest entry, however large it is.
void MapExports::Evict() {
  while (bytes_ > options_.cache_bytes && entries_.size() > 1) {
    bytes_ -= entries_.back().bytes;
    entries_.pop_back();
  }
}

}  // namespace enfilade::server
