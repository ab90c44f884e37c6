#include "server/app/session_mapping.h"

#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/app/raster_revision.h"

namespace enfilade::server {
namespace {

constexpr auto kTimeout = std::chrono::seconds(60);
constexpr std::int64_t kPortionBytes = 128 << 10;

CallContext Context() { return CallContext::WithTimeout(kTimeout); }

MappingCounts ToStored(const LogMapperCounts& counts) {
  return {.paired = counts.pairing.paired,
          .unpaired = counts.pairing.unpaired,
          .time_reversed = counts.pairing.time_reversed,
          .used = counts.used,
          .keyframes = counts.keyframes,
          .lost = counts.lost};
}

}  // namespace

SessionMapping::SessionMapping(const SessionMappingStores& stores, const SessionMappingOptions& options,
                               const Session& session, LogMapper mapper)
    : stores_(stores), options_(options), site_(session.site), session_(session.id), mapper_(std::move(mapper)) {}

absl::StatusOr<std::unique_ptr<SessionMapping>> SessionMapping::Load(const SessionMappingStores& stores,
                                                                     const SessionMappingOptions& options,
                                                                     const Session& session) {
  ENFILADE_ASSIGN_OR_RETURN(const auto stored, stores.mappings.Load(Context(), session.site, session.id));
  LogMapper mapper(options.pairing, options.slam);
  if (stored) {
    ENFILADE_ASSIGN_OR_RETURN(mapper,
                              LogMapper::Restore(options.pairing, options.slam, stored->map, stored->checkpoint));
  }
  std::unique_ptr<SessionMapping> mapping(new SessionMapping(stores, options, session, std::move(mapper)));
  mapping->mapped_sequence_ = mapping->stored_sequence_ = stored ? stored->mapped_sequence : 0;
  return mapping;
}

absl::StatusOr<SessionMapping::Progress> SessionMapping::Step(const SessionLease& lease) {
  absl::StatusOr<std::vector<Record>> records =
      stores_.records.Read(Context(), site_, session_, mapped_sequence_ + 1, kPortionBytes);
  // A mapped session whose records are gone by retention may still have its graph solved again.
  const bool records_are_gone = absl::IsFailedPrecondition(records.status());
  if (!records.ok() && !records_are_gone) return records.status();
  if (records_are_gone || records->empty()) return AtEndOfLog(lease);
  for (Record& record : *records) {
    mapped_sequence_ = record.sequence;
    mapper_.Add(std::move(record));
  }
  const auto now = std::chrono::steady_clock::now();
  if (now - last_commit_ >= options_.checkpoint_interval) {
    ENFILADE_RETURN_IF_ERROR(Commit(lease, now - last_revision_ >= options_.revision_interval, std::nullopt));
  }
  return Progress::kWorked;
}

absl::StatusOr<SessionMapping::Progress> SessionMapping::AtEndOfLog(const SessionLease& lease) {
  ENFILADE_ASSIGN_OR_RETURN(const Session session, stores_.sessions.Get(Context(), site_, session_));
  if (session.state == SessionState::kRecording) return Progress::kWaiting;
  if (mapped_sequence_ < session.acknowledged_sequence) {
    if (!session.records_deleted) return Progress::kWorked;  // more came just before the end
    return FailedPrecondition("the records from {} on were deleted before they were mapped", mapped_sequence_ + 1);
  }
  mapper_.Finish();
  ENFILADE_RETURN_IF_ERROR(Commit(lease, /*with_revision=*/true, SessionState::kMapped));
  ended_ = true;
  return Progress::kEnded;
}

absl::Status SessionMapping::Store(const SessionLease& lease) {
  if (mapped_sequence_ == stored_sequence_) return absl::OkStatus();
  const bool revision_due = std::chrono::steady_clock::now() - last_revision_ >= options_.revision_interval;
  return Commit(lease, revision_due, std::nullopt);
}

absl::Status SessionMapping::Commit(const SessionLease& lease, bool with_revision,
                                    std::optional<SessionState> final_state) {
  const SlamDelta delta = mapper_.TakeDelta();
  const std::string checkpoint = mapper_.Checkpoint();
  MappingStep step{.delta = delta,
                   .checkpoint = checkpoint,
                   .counts = ToStored(mapper_.counts()),
                   .mapped_sequence = mapped_sequence_,
                   .revision = nullptr,
                   .blobs = {},
                   .final_state = final_state,
                   .error = {}};
  RasterRevision raster;
  with_revision = with_revision && mapper_.counts().used > 0;
  if (with_revision) {
    ENFILADE_ASSIGN_OR_RETURN(raster, ToRevision(FromOccupancyGrid(mapper_.RenderGrid())));
    raster.revision.source = RevisionSource::kMapping;
    raster.revision.session = session_;
    ENFILADE_RETURN_IF_ERROR(PutTiles(Context(), stores_.blobs, site_, raster, stored_tiles_));
    step.revision = &raster.revision;
  }
  ENFILADE_RETURN_IF_ERROR(stores_.mappings.Commit(Context(), lease, step).status());
  stored_sequence_ = mapped_sequence_;
  last_commit_ = std::chrono::steady_clock::now();
  if (with_revision) {
    last_revision_ = last_commit_;
    stored_tiles_.clear();
    for (const TileRef& tile : raster.revision.tiles) stored_tiles_.insert(tile.sha256);
  }
  return absl::OkStatus();
}

absl::Status SessionMapping::Fail(const SessionMappingStores& stores, const LeasedSession& leased,
                                  const absl::Status& error) {
  ENFILADE_ASSIGN_OR_RETURN(const auto stored,
                            stores.mappings.Load(Context(), leased.lease.site, leased.lease.session));
  const SlamDelta nothing;
  const MappingStep step{.delta = nothing,
                         .checkpoint = stored ? stored->checkpoint : std::string(),
                         .counts = leased.session.mapping_counts,
                         .mapped_sequence = leased.session.mapped_sequence,
                         .revision = nullptr,
                         .blobs = {},
                         .final_state = SessionState::kFailed,
                         .error = std::string(error.message())};
  return stores.mappings.Commit(Context(), leased.lease, step).status();
}

}  // namespace enfilade::server
