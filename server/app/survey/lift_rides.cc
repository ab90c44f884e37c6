// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/lift_rides.h"

#include <optional>

#include "core/base/status_macros.h"

namespace enfilade::server {
namespace {

const storage::Map* MapOf(const storage::Session& session, const std::map<MapId, storage::Map>& maps) {
  if (!IsMapped(session)) return nullptr;
  const auto map = maps.find(*session.map);
  return map == maps.end() ? nullptr : &map->second;
}

}  // namespace

absl::StatusOr<LiftRides> FindLiftRides(const DriveReader& reader, const std::vector<storage::Session>& sessions,
                                        const std::map<MapId, storage::Map>& maps) {
  std::map<SessionId, const storage::Session*> by_id;
  for (const storage::Session& session : sessions) by_id.emplace(session.id, &session);
  LiftRides rides;
  for (const storage::Session& session : sessions) {
    if (!session.entry.previous) continue;
    const auto previous = by_id.find(*session.entry.previous);
    if (previous == by_id.end()) continue;
    const storage::Map* from = MapOf(*previous->second, maps);
    const storage::Map* to = MapOf(session, maps);
    if (from == nullptr || to == nullptr || from->level == to->level) continue;
    ENFILADE_ASSIGN_OR_RETURN(const std::optional<sensor::DoorReport> passage,
                              reader.FindPassage(previous->second->id));
    if (!passage || passage->by_hand) continue;
    if (passage->entered_level.value_or(from->level) == from->level) {
      rides.cabins.insert(to->id);
      rides.from_elsewhere.insert(session.id);
    } else {
      rides.cabins.insert(from->id);
    }
  }
  return rides;
}

}  // namespace enfilade::server
