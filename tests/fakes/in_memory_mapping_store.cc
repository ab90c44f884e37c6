// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "tests/fakes/in_memory_stores.h"
#include "tests/fakes/map_rows.h"
#include "tests/fakes/session_rows.h"

namespace enfilade::testing {
namespace {

// The session if `lease` still holds it, else null.
SessionRow* FindHeld(InMemoryDatabase::Access& access, const storage::SessionLease& lease) {
  SiteRows* const site = access.FindSite(lease.site);
  if (site == nullptr) return nullptr;
  const auto found = site->sessions.find(lease.session);
  if (found == site->sessions.end() || found->second.lease.token != lease.token) return nullptr;
  return &found->second;
}

bool IsOwner(const SessionRow* row, const storage::SessionLease& lease) {
  return row != nullptr && row->lease.owner == lease.owner;
}

TimeNs ToTime(std::chrono::steady_clock::time_point time) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
}
std::chrono::steady_clock::time_point FromTime(TimeNs time) {
  return std::chrono::steady_clock::time_point(std::chrono::nanoseconds(time));
}

bool IsHeld(const SessionRow& row, std::chrono::steady_clock::time_point now) {
  return row.lease.token > 0 && row.lease.expires_at > now;
}

// The map with the delta; FAILED_PRECONDITION if a row refers to one that does not exist.
absl::StatusOr<slam::SlamMap> Applied(slam::SlamMap map, const slam::SlamDelta& delta) {
  slam::SlamDelta rows = delta;
  rows.trajectory.clear();
  map.Apply(std::move(rows));
  for (const slam::SlamNode& node : delta.nodes) {
    if (!map.submaps.contains(node.submap)) return FailedPrecondition("submap {} does not exist", node.submap);
  }
  for (const slam::LoopClosure& closure : delta.loop_closures) {
    if (!map.submaps.contains(closure.submap) || !map.nodes.contains(closure.node)) {
      return FailedPrecondition("the submap or node of closure {} does not exist", closure.id);
    }
  }
  for (const slam::TrajectoryPoint& point : delta.trajectory) {
    if (!map.nodes.contains(point.node)) return FailedPrecondition("node {} does not exist", point.node);
    const auto place = std::lower_bound(
        map.trajectory.begin(), map.trajectory.end(), point.sequence,
        [](const slam::TrajectoryPoint& stored, std::int64_t sequence) { return stored.sequence < sequence; });
    if (place != map.trajectory.end() && place->sequence == point.sequence) {
      *place = point;
    } else {
      map.trajectory.insert(place, point);
    }
  }
  return map;
}

storage::MapState StateAfter(const storage::MappingStep& step, std::int64_t current_revision) {
  if (!step.final_state) return storage::MapState::kMapping;
  return current_revision == 0 ? storage::MapState::kEmpty : storage::MapState::kReady;
}

const storage::StoredMapping* FindMapping(InMemoryDatabase::Access& access, const SiteId& site,
                                          const SessionId& session) {
  const SiteRows* const rows = access.FindSite(site);
  if (rows == nullptr) return nullptr;
  const auto found = rows->sessions.find(session);
  return found == rows->sessions.end() || !found->second.mapping ? nullptr : &*found->second.mapping;
}

}  // namespace

absl::StatusOr<std::optional<storage::LeasedSession>> InMemoryMappingStore::Acquire(
    const storage::CallContext& context, const std::string& owner, std::chrono::milliseconds ttl) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  SessionRow* next = nullptr;
  for (auto& [site_id, site] : access.tables()) {
    for (auto& [id, row] : site.sessions) {
      if (!row.work || IsHeld(row, access.Now())) continue;
      if (!storage::IsToBeMapped(WithProgress(row), 0)) {
        row.work.reset();
      } else if (next == nullptr || row.work->turn_time < next->work->turn_time) {
        next = &row;
      }
    }
  }
  if (next == nullptr) return std::nullopt;
  next->lease = {owner, next->lease.token + 1, access.Now() + ttl, next->lease.attempts + 1};
  const storage::Session session = WithProgress(*next);
  return storage::LeasedSession{
      {session.site, session.id, owner, next->lease.token, ToTime(access.Now()), session.acknowledged_sequence},
      session,
      next->lease.attempts};
}

absl::Status InMemoryMappingStore::Renew(const storage::CallContext& context, const storage::SessionLease& lease,
                                         std::chrono::milliseconds ttl) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  SessionRow* const row = FindHeld(access, lease);
  if (!IsOwner(row, lease)) return storage::LeaseLost(lease);
  row->lease.expires_at = access.Now() + ttl;
  return absl::OkStatus();
}

absl::Status InMemoryMappingStore::Release(const storage::CallContext& context, const storage::SessionLease& lease,
                                           std::int64_t read_sequence) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  SessionRow* const row = FindHeld(access, lease);
  if (!IsOwner(row, lease)) return absl::OkStatus();
  row->lease.owner.clear();
  row->lease.attempts = 0;
  row->lease.expires_at = access.Now();
  const storage::Session session = WithProgress(*row);
  if (!storage::IsToBeMapped(session, read_sequence)) {
    row->work.reset();
    return absl::OkStatus();
  }
  if (!row->work) row->work = WorkRow{access.Now(), {}};
  row->work->turn_time = access.Now();
  if (std::max(session.mapped_sequence, read_sequence) >= lease.acknowledged_sequence) {
    row->work->waiting_since = std::max(row->work->waiting_since, FromTime(lease.take_time));
  }
  return absl::OkStatus();
}

absl::Status InMemoryMappingStore::Queue(const storage::CallContext& context, const SiteId& site,
                                         const SessionId& session) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  SiteRows* const rows = access.FindSite(site);
  if (rows == nullptr || !rows->sessions.contains(session)) return absl::OkStatus();
  SessionRow& row = rows->sessions.at(session);
  if (!row.work && storage::IsToBeMapped(WithProgress(row), 0)) row.work = WorkRow{access.Now(), {}};
  return absl::OkStatus();
}

absl::StatusOr<storage::MappingBacklog> InMemoryMappingStore::GetBacklog(const storage::CallContext& context) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  storage::MappingBacklog backlog;
  for (const auto& [site_id, site] : access.tables()) {
    for (const auto& [id, row] : site.sessions) {
      const auto& previous = row.session.entry.previous;
      if (previous && !row.session.map && !row.deleted) {
        if (const auto finished = site.sessions.at(*previous).session.finish_time) {
          ++backlog.without_map;
          backlog.longest_without_map_s =
              std::max(backlog.longest_without_map_s, 1e-9 * static_cast<double>(access.Timestamp() - *finished));
        }
      }
      if (!row.work) continue;
      ++backlog.sessions;
      const std::chrono::duration<double> waited = access.Now() - row.work->waiting_since;
      backlog.oldest_s = std::max(backlog.oldest_s, waited.count());
    }
  }
  return backlog;
}

absl::StatusOr<std::int64_t> InMemoryMappingStore::Commit(const storage::CallContext& context,
                                                          const storage::SessionLease& lease,
                                                          const storage::MappingStep& step) const {
  ENFILADE_RETURN_IF_ERROR(storage::ValidateBlobs(step.blobs));
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  SessionRow* const row = FindHeld(access, lease);
  if (row == nullptr || row->deleted || !row->session.map) return storage::LeaseLost(lease);
  const storage::StoredMapping before = row->mapping.value_or(storage::StoredMapping{});
  ENFILADE_RETURN_IF_ERROR(storage::ValidateStep(lease, {row->session.state, before.mapped_sequence}, step));
  ENFILADE_ASSIGN_OR_RETURN(slam::SlamMap map, Applied(before.map, step.delta));
  std::int64_t revision = 0;
  if (step.revision != nullptr) {
    ENFILADE_ASSIGN_OR_RETURN(revision, AddRevision(access, lease.site, *row->session.map, *step.revision, step.blobs));
  }
  if (step.revision != nullptr || step.final_state) {
    ENFILADE_ASSIGN_OR_RETURN(MapRow* const map_row, access.GetMap(lease.site, *row->session.map));
    map_row->map.state = StateAfter(step, map_row->map.current_revision);
  }
  row->mapping = storage::StoredMapping{std::move(map), std::string(step.checkpoint), step.mapped_sequence};
  row->counts = step.counts;
  if (step.final_state) {
    row->session.state = *step.final_state;
    row->session.error = *step.final_state == storage::SessionState::kFailed ? step.error : "";
  }
  return revision;
}

absl::StatusOr<std::optional<storage::StoredMapping>> InMemoryMappingStore::Load(const storage::CallContext& context,
                                                                                 const SiteId& site,
                                                                                 const SessionId& session) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  const storage::StoredMapping* const mapping = FindMapping(access, site, session);
  if (mapping == nullptr) return std::nullopt;
  return *mapping;
}

absl::StatusOr<storage::Trajectory> InMemoryMappingStore::ReadTrajectory(const storage::CallContext& context,
                                                                         const SiteId& site,
                                                                         const SessionId& session) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(const SessionRow* const row, access.GetSession(site, session));
  if (!row->mapping) return storage::Trajectory{};
  return storage::Trajectory{row->mapping->mapped_sequence, slam::TrajectoryOf(row->mapping->map)};
}

absl::StatusOr<std::vector<slam::SlamNode>> InMemoryMappingStore::ListKeyframes(const storage::CallContext& context,
                                                                                const SiteId& site,
                                                                                const SessionId& session) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  std::vector<slam::SlamNode> nodes;
  if (const storage::StoredMapping* const mapping = FindMapping(access, site, session)) {
    for (const auto& [id, node] : mapping->map.nodes) nodes.push_back(node);
  }
  return nodes;
}

absl::StatusOr<std::optional<PoseWithCovariance>> InMemoryMappingStore::FindKeyframe(
    const storage::CallContext& context, const SiteId& site, const SessionId& session, TimeNs time) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  const slam::SlamNode* nearest = nullptr;
  if (const storage::StoredMapping* const mapping = FindMapping(access, site, session)) {
    for (const auto& [id, node] : mapping->map.nodes) {
      if (nearest == nullptr || std::abs(node.time - time) < std::abs(nearest->time - time)) nearest = &node;
    }
  }
  if (nearest == nullptr) return std::nullopt;
  return PoseWithCovariance{nearest->T_map_node, nearest->covariance};
}

}  // namespace enfilade::testing
