// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "core/geometry/covariance.h"
#include "fmt/format.h"
#include "tests/fakes/in_memory_stores.h"
#include "tests/fakes/map_rows.h"
#include "tests/fakes/session_rows.h"

namespace enfilade::testing {
namespace {

absl::Status CheckReferences(const SiteRows& site, const storage::Session& session) {
  if (!site.robots.contains(session.robot)) return NotFound("{} does not exist", NameOf(session.site, session.robot));
  if (session.map && !site.maps.contains(*session.map)) {
    return NotFound("{} does not exist", NameOf(session.site, *session.map));
  }
  if (session.entry.previous && !site.sessions.contains(*session.entry.previous)) {
    return NotFound("{} does not exist", NameOf(session.site, *session.entry.previous));
  }
  return absl::OkStatus();
}

// Of a session that may have been cut.
SessionId LastPiece(const SiteRows& site, const SessionId& session) {
  const SessionId root = site.sessions.at(session).cut_from.value_or(session);
  SessionId last = root;
  for (bool found = true; std::exchange(found, false);) {
    for (const auto& [id, row] : site.sessions) {
      if (row.deleted || row.cut_from != root || row.session.entry.previous != last) continue;
      last = id;
      found = true;
      break;
    }
  }
  return last;
}

bool Matches(const storage::SessionFilter& filter, const storage::Session& session) {
  return (!filter.robot || session.robot == *filter.robot) && (!filter.map || session.map == *filter.map) &&
         (!filter.state || session.state == *filter.state);
}

void End(storage::Session& session, TimeNs time) {
  session.finish_time = time;
  if (session.state == storage::SessionState::kFailed) return;
  const bool nothing_to_map = !session.map && !session.entry.previous;
  session.state = nothing_to_map ? storage::SessionState::kMapped : storage::SessionState::kFinished;
}

void Close(SessionRow& row, TimeNs time, std::chrono::seconds idle) {
  storage::Session& session = row.session;
  if (session.state != storage::SessionState::kFailed && session.acknowledged_sequence < session.highest_sequence) {
    session.state = storage::SessionState::kFailed;
    session.error =
        fmt::format("nothing came for {} s, and record {} is missing", idle.count(), session.acknowledged_sequence + 1);
  }
  End(session, time);
}

bool IsNewer(const storage::Session& a, const storage::Session& b) {
  return a.create_time != b.create_time ? a.create_time > b.create_time : b.id < a.id;
}

}  // namespace

storage::Session WithProgress(const SessionRow& row) {
  storage::Session session = row.session;
  if (row.mapping) session.mapped_sequence = row.mapping->mapped_sequence;
  session.mapping_counts = row.counts;
  return session;
}

void QueueWork(SessionRow& row, std::chrono::steady_clock::time_point now) {
  if (!row.work && storage::IsToBeMapped(WithProgress(row), 0)) row.work = WorkRow{now, now};
}

void FollowRedirect(const SiteRows& site, storage::Session& session) {
  if (!session.map) return;
  const rearrange::MapRedirect redirect = ResolveMap(site, *session.map);
  session.map = redirect.to;
  if (auto& entry = session.entry.T_map_robot) entry = rearrange::Moved(redirect.T_to_from, *entry);
}

void DeleteSession(SessionRow& row) {
  row.deleted = true;
  row.session.map = std::nullopt;
  ++row.lease.token;
  row.lease.owner.clear();
}

absl::StatusOr<storage::Session> InMemorySessionStore::Create(const storage::CallContext& context,
                                                              const storage::Session& session,
                                                              const storage::RequestId& request_id) const {
  if (session.entry.T_map_robot) {
    ENFILADE_RETURN_IF_ERROR(
        WithContext(ValidateMeasuredCovariance(session.entry.T_map_robot->covariance), "entry.pose_map_robot"));
  }
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(SiteRows* const site, access.GetSite(session.site));
  bool taken = site->sessions.contains(session.id);
  for (const auto& [id, row] : site->sessions) {
    if (request_id.empty() || row.request_id.value != request_id.value) continue;
    if (!row.deleted) {
      ENFILADE_RETURN_IF_ERROR(storage::CheckSameRequest(storage::IsSameRequest(row.request_id, request_id)));
      return WithProgress(row);
    }
    taken = true;
  }
  if (taken) {
    return AlreadyExists("{} exists already, or was deleted: choose another id", NameOf(session.site, session.id));
  }
  ENFILADE_RETURN_IF_ERROR(CheckReferences(*site, session));
  SessionRow row;
  row.session.site = session.site;
  row.session.id = session.id;
  row.session.robot = session.robot;
  row.session.map = session.map;
  row.session.entry = session.entry;
  if (auto& previous = row.session.entry.previous) previous = LastPiece(*site, *previous);
  FollowRedirect(*site, row.session);
  row.session.create_time = access.Timestamp();
  row.request_id = request_id;
  row.append_time = access.Now();
  return site->sessions.emplace(session.id, std::move(row)).first->second.session;
}

absl::StatusOr<storage::Session> InMemorySessionStore::Get(const storage::CallContext& context, const SiteId& site,
                                                           const SessionId& session) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(const SessionRow* const row, access.GetSession(site, session));
  return WithProgress(*row);
}

absl::StatusOr<std::vector<storage::Session>> InMemorySessionStore::List(
    const storage::CallContext& context, const SiteId& site, const storage::SessionFilter& filter, int limit,
    const std::optional<storage::SessionPosition>& after) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  std::vector<storage::Session> sessions;
  const SiteRows* const rows = access.FindSite(site);
  if (rows == nullptr) return sessions;
  storage::Session last;
  if (after) {
    last.create_time = after->create_time;
    last.id = after->id;
  }
  for (const auto& [id, row] : rows->sessions) {
    if (row.deleted || !Matches(filter, row.session) || (after && !IsNewer(last, row.session))) continue;
    sessions.push_back(WithProgress(row));
  }
  std::sort(sessions.begin(), sessions.end(), IsNewer);
  if (sessions.size() > static_cast<std::size_t>(limit)) sessions.resize(static_cast<std::size_t>(limit));
  return sessions;
}

absl::StatusOr<storage::Session> InMemorySessionStore::Finish(const storage::CallContext& context, const SiteId& site,
                                                              const SessionId& session,
                                                              std::int64_t last_sequence) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(SessionRow* const row, access.GetSession(site, session));
  storage::Session& stored = row->session;
  const std::int64_t highest = row->recorded_sequence.value_or(stored.highest_sequence);
  if (highest != last_sequence) {
    return FailedPrecondition("{} cannot finish at record {}: the highest that is stored is {}", NameOf(site, session),
                              last_sequence, highest);
  }
  if (stored.acknowledged_sequence != stored.highest_sequence) {
    return FailedPrecondition("{} cannot finish: record {} is missing", NameOf(site, session),
                              stored.acknowledged_sequence + 1);
  }
  if (!stored.finish_time) {
    End(stored, access.Timestamp());
    QueueWork(*row, access.Now());
  }
  return WithProgress(*row);
}

absl::StatusOr<storage::ClosedSessions> InMemorySessionStore::CloseIdle(const storage::CallContext& context,
                                                                        std::chrono::seconds idle,
                                                                        std::int64_t limit) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  storage::ClosedSessions closed;
  for (auto& [site_id, site] : access.tables()) {
    for (auto& [id, row] : site.sessions) {
      if (closed.finished + closed.failed >= limit) return closed;
      if (row.deleted || row.session.finish_time || row.append_time > access.Now() - idle) continue;
      Close(row, access.Timestamp(), idle);
      QueueWork(row, access.Now());
      ++(row.session.state == storage::SessionState::kFailed ? closed.failed : closed.finished);
    }
  }
  return closed;
}

absl::Status InMemorySessionStore::Delete(const storage::CallContext& context, const SiteId& site,
                                          const SessionId& session) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(SessionRow* const row, access.GetSession(site, session));
  DeleteSession(*row);
  return absl::OkStatus();
}

}  // namespace enfilade::testing
