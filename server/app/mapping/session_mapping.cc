// SPDX-License-Identifier: Apache-2.0
#include "server/app/mapping/session_mapping.h"

#include <utility>
#include <vector>

#include "core/base/environment.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/app/edits/edited_revision.h"
#include "server/app/mapping/layer_runs.h"
#include "server/app/mapping/raster_revision.h"
#include "server/app/mapping/session_entry.h"
#include "spdlog/spdlog.h"

namespace enfilade::server {
namespace {

constexpr auto kMappingTimeout = std::chrono::seconds(60);
constexpr std::int64_t kRecordPortionBytes = 128 << 10;
// Limits how often a revision is composed again because other sessions of the map changed their layers.
constexpr int kMaxCompositions = 100;

storage::CallContext MappingContext() { return storage::CallContext::WithTimeout(kMappingTimeout); }

storage::MappingCounts ToStored(const slam::LogMapperCounts& counts) {
  return {.paired = counts.pairing.paired,
          .unpaired = counts.pairing.unpaired,
          .time_reversed = counts.pairing.time_reversed,
          .used = counts.used,
          .keyframes = counts.keyframes,
          .lost = counts.lost};
}

absl::StatusOr<slam::SlamOptions> SlamOptionsOf(const SessionMappingStores& stores, const slam::SlamProfiles& profiles,
                                                const storage::Session& session) {
  ENFILADE_ASSIGN_OR_RETURN(const storage::Map map, stores.maps.Get(MappingContext(), session.site, *session.map));
  if (const slam::SlamOptions* own = profiles.Find(map.slam_profile)) return *own;
  const char* fallback =
      map.environment == Environment::kOutdoor ? slam::SlamProfiles::kOutdoor : slam::SlamProfiles::kIndoor;
  if (!map.slam_profile.empty()) {
    spdlog::warn("mapping: map {}: this server has no SLAM profile \"{}\"; using \"{}\"", map.id.value(),
                 map.slam_profile, fallback);
  }
  return *profiles.Find(fallback);
}

}  // namespace

SessionMapping::SessionMapping(const SessionMappingStores& stores, const SessionMappingOptions& options,
                               const storage::Session& session, slam::SlamOptions slam)
    : stores_(stores),
      options_(options),
      site_(session.site),
      session_(session.id),
      robot_(session.robot),
      map_(*session.map),
      slam_(std::move(slam)),
      overlay_(stores.blobs, session.site) {}

absl::StatusOr<std::unique_ptr<SessionMapping>> SessionMapping::Load(const SessionMappingStores& stores,
                                                                     const SessionMappingOptions& options,
                                                                     const storage::Session& session) {
  ENFILADE_ASSIGN_OR_RETURN(const auto stored, stores.mappings.Load(MappingContext(), session.site, session.id));
  ENFILADE_ASSIGN_OR_RETURN(const slam::SlamOptions slam, SlamOptionsOf(stores, options.slam, session));
  std::unique_ptr<SessionMapping> mapping(new SessionMapping(stores, options, session, slam));
  if (stored) {
    ENFILADE_ASSIGN_OR_RETURN(mapping->mapper_,
                              slam::LogMapper::Restore(options.pairing, slam, stored->map, stored->checkpoint));
    mapping->mapped_sequence_ = mapping->stored_sequence_ = stored->mapped_sequence;
  } else {
    ENFILADE_RETURN_IF_ERROR(mapping->Begin(session));
  }
  return mapping;
}

absl::Status SessionMapping::Begin(const storage::Session& session) {
  grid::OccupancyGrid existing;
  const auto revision = stores_.revisions.Get(MappingContext(), site_, map_, 0);
  if (revision.ok()) {
    // Not what people have drawn: glass that scanners cannot see must not bend the map.
    ENFILADE_ASSIGN_OR_RETURN(const grid::MapRaster raster,
                              ReadEvidence(MappingContext(), {stores_.blobs, stores_.revisions}, *revision));
    ENFILADE_ASSIGN_OR_RETURN(existing, OnMapLattice(raster, slam_.resolution));
  } else if (!absl::IsNotFound(revision.status())) {
    return revision.status();
  }
  if (session.entry.T_map_robot) {
    ENFILADE_ASSIGN_OR_RETURN(slam::ExistingMapEntry entry,
                              ReadEntry(stores_.sessions, stores_.records, options_.pairing, slam_, session));
    mapper_.emplace(options_.pairing, slam_, slam::ExistingMap{std::move(existing), std::move(entry)});
  } else if (existing.cells.empty()) {
    mapper_.emplace(options_.pairing, slam_);
  } else {
    location_.emplace(options_.pairing, std::move(existing));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<sensor::Record>> SessionMapping::ReadAfter(std::int64_t sequence) const {
  auto records = stores_.records.Read(MappingContext(), site_, session_, sequence + 1, kRecordPortionBytes);
  // The records of a completely mapped session may be deleted by retention.
  if (absl::IsFailedPrecondition(records.status())) return std::vector<sensor::Record>();
  return records;
}

// Once the robot is located, mapping starts at the beginning of the log.
absl::StatusOr<SessionMapping::Progress> SessionMapping::LocateStep() {
  ENFILADE_ASSIGN_OR_RETURN(std::vector<sensor::Record> records, ReadAfter(looked_sequence_));
  if (records.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(const storage::Session session, stores_.sessions.Get(MappingContext(), site_, session_));
    if (session.state == storage::SessionState::kRecording) return Progress::kWaiting;
    if (looked_sequence_ < session.acknowledged_sequence && !session.records_deleted) return Progress::kWorked;
    ENFILADE_RETURN_IF_ERROR(location_->Finish());
  }
  for (sensor::Record& record : records) {
    looked_sequence_ = record.sequence;
    ENFILADE_RETURN_IF_ERROR(location_->Add(std::move(record)));
  }
  if (std::optional<slam::ExistingMap> existing = location_->TakeLocated()) {
    mapper_.emplace(options_.pairing, slam_, *existing);
    location_.reset();
  } else if (records.empty()) {
    mapper_.emplace(options_.pairing, slam_);
    location_.reset();  // the session has no scans
  }
  return Progress::kWorked;
}

absl::StatusOr<SessionMapping::Progress> SessionMapping::Step(const storage::SessionLease& lease) {
  if (location_) return LocateStep();
  ENFILADE_ASSIGN_OR_RETURN(std::vector<sensor::Record> records, ReadAfter(mapped_sequence_));
  if (records.empty()) return AtEndOfLog(lease);
  for (sensor::Record& record : records) {
    mapped_sequence_ = record.sequence;
    mapper_->Add(std::move(record));
  }
  const auto now = std::chrono::steady_clock::now();
  if (now - last_commit_ >= options_.checkpoint_interval) {
    ENFILADE_RETURN_IF_ERROR(Commit(lease, now - last_revision_ >= options_.revision_interval, std::nullopt));
  }
  return Progress::kWorked;
}

absl::StatusOr<SessionMapping::Progress> SessionMapping::AtEndOfLog(const storage::SessionLease& lease) {
  ENFILADE_ASSIGN_OR_RETURN(const storage::Session session, stores_.sessions.Get(MappingContext(), site_, session_));
  if (session.state == storage::SessionState::kRecording) return Progress::kWaiting;
  if (mapped_sequence_ < session.acknowledged_sequence) {
    if (!session.records_deleted) return Progress::kWorked;  // more records came just before the end
    return FailedPrecondition("the records from sequence {} on were deleted before they were mapped",
                              mapped_sequence_ + 1);
  }
  mapper_->Finish();
  ENFILADE_RETURN_IF_ERROR(Commit(lease, /*with_revision=*/true, storage::SessionState::kMapped));
  ended_ = true;
  return Progress::kEnded;
}

bool SessionMapping::overdue() const {
  return !stored() && std::chrono::steady_clock::now() - last_commit_ >= options_.checkpoint_interval;
}

std::size_t SessionMapping::bytes() const {
  return sizeof(*this) + overlay_.bytes() + (location_ ? location_->bytes() : 0) +
         (mapper_ ? mapper_->footprint().total() : 0);
}

absl::Status SessionMapping::StoreIfDue(const storage::SessionLease& lease) {
  if (overdue()) return Store(lease);
  if (!stored()) StorePose();
  return absl::OkStatus();
}

absl::Status SessionMapping::Store(const storage::SessionLease& lease) {
  if (stored()) return absl::OkStatus();
  const bool revision_due = std::chrono::steady_clock::now() - last_revision_ >= options_.revision_interval;
  return Commit(lease, revision_due, std::nullopt);
}

absl::Status SessionMapping::Commit(const storage::SessionLease& lease, bool with_revision,
                                    std::optional<storage::SessionState> final_state) {
  const slam::SlamDelta delta = mapper_->TakeDelta();
  const std::string checkpoint = mapper_->Checkpoint();
  storage::MappingStep step{.delta = delta,
                            .checkpoint = checkpoint,
                            .counts = ToStored(mapper_->counts()),
                            .mapped_sequence = mapped_sequence_,
                            .revision = nullptr,
                            .blobs = {},
                            .final_state = final_state,
                            .error = {}};
  const grid::OccupancyGrid own = with_revision ? mapper_->RenderGrid() : grid::OccupancyGrid{};
  if (own.cells.empty()) {
    ENFILADE_RETURN_IF_ERROR(stores_.mappings.Commit(MappingContext(), lease, step).status());
  } else {
    ENFILADE_RETURN_IF_ERROR(CommitRevision(lease, own, step));
  }
  stored_sequence_ = mapped_sequence_;
  last_commit_ = std::chrono::steady_clock::now();
  if (with_revision) last_revision_ = last_commit_;
  StorePose();
  return absl::OkStatus();
}

absl::StatusOr<storage::LayersBeside> SessionMapping::ReadLayersBeside(double resolution) const {
  ENFILADE_ASSIGN_OR_RETURN(storage::LayersBeside beside,
                            stores_.revisions.ReadRunsBeside(MappingContext(), site_, map_, session_, resolution));
  const LayerRuns runs(stores_.blobs, stores_.revisions, site_, map_);
  while (true) {
    ENFILADE_ASSIGN_OR_RETURN(const bool made, runs.MakeNext(MappingContext(), resolution, beside));
    if (!made) return beside;
  }
}

// If another session changes its layer meanwhile, composes the revision again.
absl::Status SessionMapping::CommitRevision(const storage::SessionLease& lease, const grid::OccupancyGrid& own,
                                            storage::MappingStep& step) {
  ENFILADE_ASSIGN_OR_RETURN(RasterRevision layer, ToRevision(grid::FromOccupancyGrid(own)));
  ENFILADE_RETURN_IF_ERROR(PutTiles(MappingContext(), stores_.blobs, site_, layer, stored_tiles_));
  std::set<std::string> tiles;
  for (const storage::TileRef& tile : layer.revision.tiles) tiles.insert(tile.sha256);
  if (step.final_state) {
    const LayerRuns runs(stores_.blobs, stores_.revisions, site_, map_);
    ENFILADE_RETURN_IF_ERROR(runs.MergeOrphaned(MappingContext()).status());
  }
  absl::Status status;
  for (int attempt = 0; attempt < kMaxCompositions; ++attempt) {
    ENFILADE_ASSIGN_OR_RETURN(const storage::LayersBeside beside, ReadLayersBeside(own.geometry.resolution));
    RasterRevision whole;
    whole.revision = layer.revision;
    if (!beside.below.empty() || !beside.above.empty() || beside.edits || !beside.ignored.empty()) {
      ENFILADE_ASSIGN_OR_RETURN(grid::OccupancyGrid grid, overlay_.Compose(MappingContext(), beside, own));
      std::set<std::string> known = stored_tiles_;
      known.insert(tiles.begin(), tiles.end());
      ENFILADE_ASSIGN_OR_RETURN(whole, StoreEdited(MappingContext(), {stores_.blobs, stores_.revisions}, {site_, map_},
                                                   beside.edits, grid::FromOccupancyGrid(std::move(grid)), known));
      whole.revision.layer = storage::StoredRaster{layer.revision.raster_header, layer.revision.tiles};
    }
    whole.revision.source = storage::RevisionSource::kMapping;
    whole.revision.session = session_;
    whole.revision.layers_version = beside.version;
    step.revision = &whole.revision;
    status = stores_.mappings.Commit(MappingContext(), lease, step).status();
    step.revision = nullptr;
    if (storage::AreLayersChanged(status)) continue;
    ENFILADE_RETURN_IF_ERROR(status);
    for (const storage::TileRef& tile : whole.revision.tiles) tiles.insert(tile.sha256);
    stored_tiles_ = std::move(tiles);
    return absl::OkStatus();
  }
  return status;
}

// Not part of the commit: if it fails, the stored pose is only older.
void SessionMapping::StorePose() const {
  const std::optional<slam::PresentPose> pose = mapper_->FindPresentPose();
  if (!pose || pose->lost) return;
  const absl::Status status =
      stores_.robot_poses.Report(MappingContext(), {site_, robot_, map_, session_, pose->T_map_robot, pose->time, 0});
  if (!status.ok()) spdlog::warn("mapping: the pose of robot {} was not stored: {}", robot_.value(), status.ToString());
}

absl::Status SessionMapping::Fail(const SessionMappingStores& stores, const storage::LeasedSession& leased,
                                  const absl::Status& error) {
  ENFILADE_ASSIGN_OR_RETURN(const auto stored,
                            stores.mappings.Load(MappingContext(), leased.lease.site, leased.lease.session));
  const slam::SlamDelta nothing;
  const std::string checkpoint = stored ? stored->checkpoint : std::string();  // the step only refers to it
  const storage::MappingStep step{.delta = nothing,
                                  .checkpoint = checkpoint,
                                  .counts = leased.session.mapping_counts,
                                  .mapped_sequence = leased.session.mapped_sequence,
                                  .revision = nullptr,
                                  .blobs = {},
                                  .final_state = storage::SessionState::kFailed,
                                  .error = std::string(error.message())};
  return stores.mappings.Commit(MappingContext(), leased.lease, step).status();
}

}  // namespace enfilade::server
