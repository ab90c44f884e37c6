// SPDX-License-Identifier: Apache-2.0
#include "storage/mapping_store.h"

#include "core/base/resource_name.h"
#include "storage/map_store.h"
#include "storage/postgres/driver/pose_columns.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/graph/link_point_rows.h"
#include "storage/postgres/maps/blob_rows.h"
#include "storage/postgres/maps/revision_rows.h"
#include "storage/postgres/sessions/session_row.h"
#include "storage/postgres/sessions/slam_rows.h"

namespace enfilade::storage {
namespace {

using postgres::Bytes;
using postgres::Params;
using postgres::Row;
using postgres::Statement;
using postgres::Transaction;

// Whoever wants to take the lease, or to delete the session, waits for this transaction.
constexpr Statement kLockSessionLease{"locking the lease",
                                      "SELECT token FROM enfilade.session_leases"
                                      " WHERE site_id = $1 AND session_id = $2 FOR UPDATE"};
// A statement of its own: it sees a deletion that the lock has waited for.
constexpr Statement kSelectMappedSession{
    "reading the session",
    "SELECT s.map_id, s.state, coalesce(c.mapped_sequence, 0) FROM enfilade.sessions s"
    " LEFT JOIN enfilade.mapping_checkpoints c USING (site_id, session_id)"
    " WHERE s.site_id = $1 AND s.session_id = $2 AND s.delete_time IS NULL AND s.map_id IS NOT NULL"};
constexpr Statement kUpsertCheckpoint{
    "storing the checkpoint",
    "INSERT INTO enfilade.mapping_checkpoints (site_id, session_id, mapped_sequence, token, paired, unpaired,"
    "   time_reversed, used, keyframes, lost, state) VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11)"
    " ON CONFLICT (site_id, session_id) DO UPDATE SET mapped_sequence = EXCLUDED.mapped_sequence,"
    " token = EXCLUDED.token, paired = EXCLUDED.paired, unpaired = EXCLUDED.unpaired,"
    " time_reversed = EXCLUDED.time_reversed, used = EXCLUDED.used, keyframes = EXCLUDED.keyframes,"
    " lost = EXCLUDED.lost, state = EXCLUDED.state"};
constexpr Statement kUpsertTrack{
    "storing the track",
    "INSERT INTO enfilade.session_tracks (site_id, session_id, map_id, track)"
    " SELECT $1, $2, $3, ST_MakeLine(ST_MakePointM(x, y, time_ns / 1e9) ORDER BY node_id) FROM enfilade.slam_nodes"
    " WHERE site_id = $1 AND session_id = $2 HAVING count(*) >= 2"
    " ON CONFLICT (site_id, session_id) DO UPDATE SET map_id = EXCLUDED.map_id, track = EXCLUDED.track"};
constexpr Statement kSetFinalState{"closing the session",
                                   "UPDATE enfilade.sessions SET state = $3, error = $4"
                                   " WHERE site_id = $1 AND session_id = $2"};
constexpr Statement kSetMapReady{"updating the map",
                                 "UPDATE enfilade.maps SET state = CASE current_revision WHEN 0 THEN 1 ELSE 3 END"
                                 " WHERE site_id = $1 AND map_id = $2"};
// Shared with other readers; a step, which writes this row before it commits, waits. So what is read after it is of
// one moment.
constexpr Statement kLockCheckpoint{"reading the checkpoint",
                                    "SELECT mapped_sequence, state FROM enfilade.mapping_checkpoints"
                                    " WHERE site_id = $1 AND session_id = $2 FOR SHARE"};
constexpr Statement kSelectTrajectory{
    "reading the trajectory",
    "SELECT p.time_ns, n.x, n.y, n.yaw, p.x, p.y, p.yaw FROM enfilade.trajectory_points p"
    " JOIN enfilade.slam_nodes n ON (n.site_id, n.session_id, n.node_id) = (p.site_id, p.session_id, p.node_id)"
    " WHERE p.site_id = $1 AND p.session_id = $2 ORDER BY p.sequence"};

constexpr Statement kFindKeyframe{
    "looking for the nearest keyframe",
    "SELECT x, y, yaw, covariance FROM enfilade.slam_nodes"
    " WHERE site_id = $1 AND session_id = $2 ORDER BY abs(time_ns - $3), node_id LIMIT 1"};

struct Target {
  MapId map;
  SessionState state = SessionState::kRecording;
  std::int64_t mapped_sequence = 0;
};

Target ReadTarget(Row& row) {
  Target target;
  target.map = MapId(std::string(row.Text()));
  target.state = static_cast<SessionState>(row.Int16());
  target.mapped_sequence = row.Int64();
  return target;
}

absl::StatusOr<Target> LockTarget(Transaction& transaction, const SessionLease& lease) {
  transaction.Queue(kLockSessionLease, Params(lease.site, lease.session));
  transaction.Queue(kSelectMappedSession, Params(lease.site, lease.session));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.Flush());
  const absl::Status lost = Aborted("{} has lost the lease on {}", lease.owner, NameOf(lease.site, lease.session));
  if (results[0].rows() == 0 || results[1].rows() == 0) return lost;
  Row row(results[0], 0);
  if (row.Int64() != lease.token) return lost;
  return storage::postgres::ReadOne(results[1], ReadTarget, NameOf(lease.site, lease.session));
}

absl::Status ValidateStep(const SessionLease& lease, const Target& target, const MappingStep& step) {
  if (step.mapped_sequence < target.mapped_sequence) {
    return InvalidArgument("mapping of {} stands at record {} and cannot go back to {}",
                           NameOf(lease.site, lease.session), target.mapped_sequence, step.mapped_sequence);
  }
  if (!step.final_state) return absl::OkStatus();
  if (*step.final_state != SessionState::kMapped && *step.final_state != SessionState::kFailed) {
    return InvalidArgument("the final state {} is neither mapped nor failed", static_cast<int>(*step.final_state));
  }
  const bool closed = target.state == SessionState::kFinished || target.state == *step.final_state;
  if (*step.final_state == SessionState::kMapped && !closed) {
    return FailedPrecondition("{} is not finished: more records may come", NameOf(lease.site, lease.session));
  }
  return absl::OkStatus();
}

void QueueCheckpoint(Transaction& transaction, const SessionLease& lease, const MappingStep& step) {
  const MappingCounts& counts = step.counts;
  transaction.Queue(kUpsertCheckpoint,
                    Params(lease.site, lease.session, step.mapped_sequence, lease.token, counts.paired, counts.unpaired,
                           counts.time_reversed, counts.used, counts.keyframes, counts.lost, Bytes{step.checkpoint}));
}

}  // namespace

absl::StatusOr<std::int64_t> MappingStore::Commit(const CallContext& context, const SessionLease& lease,
                                                  const MappingStep& step) const {
  ENFILADE_RETURN_IF_ERROR(postgres::ValidateBlobs(step.blobs));
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const Target target, LockTarget(transaction, lease));
  ENFILADE_RETURN_IF_ERROR(ValidateStep(lease, target, step));
  postgres::QueueDelta(transaction, lease.site, lease.session, step.delta);
  QueueCheckpoint(transaction, lease, step);
  std::int64_t revision = 0;
  if (step.revision) {
    const MapState state = step.final_state ? MapState::kReady : MapState::kMapping;
    const auto added =
        storage::postgres::AddRevision(transaction, lease.site, target.map, *step.revision, step.blobs, state);
    if (!added.ok()) return postgres::ExplainRevisionError(added.status(), lease.site, target.map);
    revision = *added;
  } else if (step.final_state) {
    transaction.Queue(kSetMapReady, Params(lease.site, target.map));
  }
  if (step.revision || step.final_state) {
    transaction.Queue(kUpsertTrack, Params(lease.site, lease.session, target.map));
  }
  if (step.final_state) {
    const bool failed = *step.final_state == SessionState::kFailed;
    transaction.Queue(kSetFinalState, Params(lease.site, lease.session, static_cast<std::int16_t>(*step.final_state),
                                             failed ? std::optional<std::string_view>(step.error) : std::nullopt));
  }
  const absl::Status committed = transaction.Commit();
  if (!committed.ok()) return postgres::ExplainRevisionError(committed, lease.site, target.map);
  return revision;
}

absl::StatusOr<std::optional<StoredMapping>> MappingStore::Load(const CallContext& context, const SiteId& site,
                                                                const SessionId& session) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  transaction.Queue(kLockCheckpoint, Params(site, session));
  postgres::QueueSlamMap(transaction, site, session);
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  if (results[0].rows() == 0) return std::nullopt;
  StoredMapping stored;
  Row row(results[0], 0);
  stored.mapped_sequence = row.Int64();
  stored.checkpoint = row.Bytes();
  ENFILADE_RETURN_IF_ERROR(row.status());
  ENFILADE_ASSIGN_OR_RETURN(stored.map, postgres::ReadSlamMap(results[1], results[2], results[3], results[4]));
  return stored;
}

absl::StatusOr<Trajectory> MappingStore::ReadTrajectory(const CallContext& context, const SiteId& site,
                                                        const SessionId& session) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  transaction.Queue(kLockCheckpoint, Params(site, session));
  transaction.Queue(kSelectTrajectory, Params(site, session));
  transaction.Queue(postgres::kSessionExists, Params(site, session));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  if (results[2].rows() == 0) return NotFound("{} does not exist", NameOf(site, session));
  Trajectory trajectory;
  if (results[0].rows() == 0) return trajectory;
  Row row(results[0], 0);
  trajectory.mapped_sequence = row.Int64();
  ENFILADE_RETURN_IF_ERROR(row.status());
  ENFILADE_ASSIGN_OR_RETURN(trajectory.poses, storage::postgres::ReadRows(results[1], [](Row& point) {
                              const TimeNs time = point.Int64();
                              const Pose2 T_map_node = storage::postgres::ReadPose(point);
                              return slam::StampedPose{time, T_map_node * storage::postgres::ReadPose(point)};
                            }));
  return trajectory;
}

absl::StatusOr<std::vector<slam::SlamNode>> MappingStore::ListKeyframes(const CallContext& context, const SiteId& site,
                                                                        const SessionId& session) const {
  return postgres::ListNodes(pool_, context, site, session);
}

absl::StatusOr<std::optional<PoseWithCovariance>> MappingStore::FindKeyframe(const CallContext& context,
                                                                             const SiteId& site,
                                                                             const SessionId& session,
                                                                             TimeNs time) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto found,
                            postgres::ExecuteAlone(pool_, context, kFindKeyframe, Params(site, session, time)));
  if (found.rows() == 0) return std::nullopt;
  Row row(found, 0);
  PoseWithCovariance keyframe;
  keyframe.pose = storage::postgres::ReadPose(row);
  keyframe.covariance = postgres::ReadCovariance(row);
  ENFILADE_RETURN_IF_ERROR(row.status());
  return std::optional<PoseWithCovariance>(keyframe);
}

}  // namespace enfilade::storage
