// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/sessions/mapping_store.h"

#include "core/base/resource_name.h"
#include "storage/maps/map_store.h"
#include "storage/postgres/driver/pose_columns.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/graph/link_point_rows.h"
#include "storage/postgres/maps/revision_rows.h"
#include "storage/postgres/sessions/mapping_work.h"
#include "storage/postgres/sessions/session_leases.h"
#include "storage/postgres/sessions/session_row.h"
#include "storage/postgres/sessions/slam_rows.h"

namespace enfilade::storage::postgres {
namespace {

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
// Blocks steps, which write this row, but no other readers: the statements after it read the result of one step.
constexpr Statement kLockCheckpoint{"reading the checkpoint",
                                    "SELECT mapped_sequence, state FROM enfilade.mapping_checkpoints"
                                    " WHERE site_id = $1 AND session_id = $2 FOR SHARE"};
constexpr Statement kSelectTrajectoryPoses{
    "reading the trajectory",
    "SELECT p.time_ns, n.x, n.y, n.yaw, p.x, p.y, p.yaw FROM enfilade.trajectory_points p"
    " JOIN enfilade.slam_nodes n ON (n.site_id, n.session_id, n.node_id) = (p.site_id, p.session_id, p.node_id)"
    " WHERE p.site_id = $1 AND p.session_id = $2 ORDER BY p.sequence"};

constexpr Statement kFindKeyframe{
    "looking for the nearest keyframe",
    "SELECT x, y, yaw, covariance FROM enfilade.slam_nodes"
    " WHERE site_id = $1 AND session_id = $2 ORDER BY abs(time_ns - $3), node_id LIMIT 1"};

void QueueCheckpoint(Transaction& transaction, const SessionLease& lease, const MappingStep& step) {
  const MappingCounts& counts = step.counts;
  transaction.Queue(kUpsertCheckpoint,
                    Params(lease.site, lease.session, step.mapped_sequence, lease.token, counts.paired, counts.unpaired,
                           counts.time_reversed, counts.used, counts.keyframes, counts.lost, Bytes{step.checkpoint}));
}

void QueueFinalState(Transaction& transaction, const SessionLease& lease, const MappingStep& step) {
  const bool failed = *step.final_state == SessionState::kFailed;
  transaction.Queue(kSetFinalState, Params(lease.site, lease.session, static_cast<std::int16_t>(*step.final_state),
                                           failed ? std::optional<std::string_view>(step.error) : std::nullopt));
}

}  // namespace

absl::StatusOr<std::optional<LeasedSession>> MappingStore::Acquire(const CallContext& context, const std::string& owner,
                                                                   std::chrono::milliseconds ttl) const {
  return AcquireSession(pool_, context, owner, ttl);
}

absl::Status MappingStore::Renew(const CallContext& context, const SessionLease& lease,
                                 std::chrono::milliseconds ttl) const {
  return RenewLease(pool_, context, lease, ttl);
}

absl::Status MappingStore::Release(const CallContext& context, const SessionLease& lease,
                                   std::int64_t read_sequence) const {
  return ReleaseLease(pool_, context, lease, read_sequence);
}

absl::Status MappingStore::Queue(const CallContext& context, const SiteId& site, const SessionId& session) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  QueueMappingWork(transaction, site, {session.value()});
  return transaction.Commit();
}

absl::StatusOr<MappingBacklog> MappingStore::GetBacklog(const CallContext& context) const {
  return ReadMappingBacklog(pool_, context);
}

absl::StatusOr<std::int64_t> MappingStore::Commit(const CallContext& context, const SessionLease& lease,
                                                  const MappingStep& step) const {
  ENFILADE_RETURN_IF_ERROR(ValidateBlobs(step.blobs));
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const HeldSession held, LockLease(transaction, lease));
  ENFILADE_RETURN_IF_ERROR(ValidateStep(lease, held.progress, step));
  QueueDelta(transaction, lease.site, lease.session, step.delta);
  QueueCheckpoint(transaction, lease, step);
  std::int64_t revision = 0;
  if (step.revision) {
    const MapState state = step.final_state ? MapState::kReady : MapState::kMapping;
    const auto added = AddRevision(transaction, {lease.site, held.map}, *step.revision, step.blobs, state);
    if (!added.ok()) return ExplainRevisionError(added.status(), lease.site, held.map);
    revision = *added;
  } else if (step.final_state) {
    transaction.Queue(kSetMapReady, Params(lease.site, held.map));
  }
  if (step.revision || step.final_state) {
    transaction.Queue(kUpsertTrack, Params(lease.site, lease.session, held.map));
  }
  if (step.final_state) QueueFinalState(transaction, lease, step);
  const absl::Status committed = transaction.Commit();
  if (!committed.ok()) return ExplainRevisionError(committed, lease.site, held.map);
  return revision;
}

absl::StatusOr<std::optional<StoredMapping>> MappingStore::Load(const CallContext& context, const SiteId& site,
                                                                const SessionId& session) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  transaction.Queue(kLockCheckpoint, Params(site, session));
  QueueSlamMap(transaction, site, session);
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  if (results[0].rows() == 0) return std::nullopt;
  StoredMapping stored;
  Row row(results[0], 0);
  stored.mapped_sequence = row.Int64();
  stored.checkpoint = row.Bytes();
  ENFILADE_RETURN_IF_ERROR(row.status());
  ENFILADE_ASSIGN_OR_RETURN(stored.map, ReadSlamMap(results[1], results[2], results[3], results[4]));
  return stored;
}

absl::StatusOr<Trajectory> MappingStore::ReadTrajectory(const CallContext& context, const SiteId& site,
                                                        const SessionId& session) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  transaction.Queue(kLockCheckpoint, Params(site, session));
  transaction.Queue(kSelectTrajectoryPoses, Params(site, session));
  transaction.Queue(kSessionExists, Params(site, session));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  if (results[2].rows() == 0) return NotFound("{} does not exist", NameOf(site, session));
  Trajectory trajectory;
  if (results[0].rows() == 0) return trajectory;
  Row row(results[0], 0);
  trajectory.mapped_sequence = row.Int64();
  ENFILADE_RETURN_IF_ERROR(row.status());
  ENFILADE_ASSIGN_OR_RETURN(trajectory.poses, ReadRows(results[1], [](Row& point) {
                              const TimeNs time = point.Int64();
                              const Pose2 T_map_node = ReadPose(point);
                              return slam::StampedPose{time, T_map_node * ReadPose(point)};
                            }));
  return trajectory;
}

absl::StatusOr<std::vector<slam::SlamNode>> MappingStore::ListKeyframes(const CallContext& context, const SiteId& site,
                                                                        const SessionId& session) const {
  return ListNodes(pool_, context, site, session);
}

absl::StatusOr<std::optional<PoseWithCovariance>> MappingStore::FindKeyframe(const CallContext& context,
                                                                             const SiteId& site,
                                                                             const SessionId& session,
                                                                             TimeNs time) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto found, ExecuteAlone(pool_, context, kFindKeyframe, Params(site, session, time)));
  if (found.rows() == 0) return std::nullopt;
  Row row(found, 0);
  PoseWithCovariance keyframe;
  keyframe.pose = ReadPose(row);
  keyframe.covariance = ReadCovariance(row);
  ENFILADE_RETURN_IF_ERROR(row.status());
  return std::optional<PoseWithCovariance>(keyframe);
}

}  // namespace enfilade::storage::postgres
