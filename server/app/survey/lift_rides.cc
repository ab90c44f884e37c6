// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/lift_rides.h"

#include <optional>
#include <vector>

#include "core/base/status_macros.h"

namespace enfilade::server {
namespace {

const storage::Map* MapOf(const storage::Session& session, const std::map<MapId, storage::Map>& maps) {
  if (!IsSettled(session)) return nullptr;
  const auto map = maps.find(*session.map);
  return map == maps.end() ? nullptr : &map->second;
}

// A session that follows another one, and the maps that they are in.
struct Succession {
  const storage::Session* previous = nullptr;
  const storage::Session* session = nullptr;
  const storage::Map* from = nullptr;
  const storage::Map* to = nullptr;

  bool changes_level() const { return from->level != to->level; }
};

std::vector<Succession> SuccessionsOf(const std::vector<storage::Session>& sessions,
                                      const std::map<MapId, storage::Map>& maps) {
  std::map<SessionId, const storage::Session*> by_id;
  for (const storage::Session& session : sessions) by_id.emplace(session.id, &session);
  std::vector<Succession> successions;
  for (const storage::Session& session : sessions) {
    if (!session.entry.previous) continue;
    const auto previous = by_id.find(*session.entry.previous);
    if (previous == by_id.end()) continue;
    const Succession one{previous->second, &session, MapOf(*previous->second, maps), MapOf(session, maps)};
    if (one.from != nullptr && one.to != nullptr) successions.push_back(one);
  }
  return successions;
}

}  // namespace

absl::StatusOr<LiftRides> FindLiftRides(const DriveReader& reader, const std::vector<storage::Session>& sessions,
                                        const std::map<MapId, storage::Map>& maps) {
  const std::vector<Succession> successions = SuccessionsOf(sessions, maps);
  LiftRides rides;
  for (const storage::Session& session : sessions) {
    if (session.entry.previous && !IsSettled(session)) rides.going_on.insert(*session.entry.previous);
  }
  std::set<SessionId> cut_off;  // no passage leads to them: they and the sessions before them were one
  for (const Succession& one : successions) {
    if (!one.changes_level()) continue;
    rides.next[one.previous->id] = {one.session->id, one.to->id};
    ENFILADE_ASSIGN_OR_RETURN(const std::optional<sensor::DoorReport> passage, reader.FindPassage(one.previous->id));
    if (!passage) {
      cut_off.insert(one.session->id);
    } else if (!passage->by_hand) {
      const bool enters = passage->entered_level.value_or(one.from->level) == one.from->level;
      rides.cabins.insert(enters ? one.to->id : one.from->id);
      if (enters) rides.from_elsewhere.insert(one.session->id);
    }
  }
  for (const Succession& one : successions) {
    const bool goes_on = one.from == one.to && rides.from_elsewhere.contains(one.previous->id);
    const bool begins = cut_off.contains(one.session->id) && rides.cabins.contains(one.to->id);
    if (goes_on || begins) rides.from_elsewhere.insert(one.session->id);
  }
  return rides;
}

}  // namespace enfilade::server
