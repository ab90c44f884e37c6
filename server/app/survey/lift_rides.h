// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <set>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "server/app/survey/drive_reader.h"
#include "storage/maps/map_store.h"
#include "storage/sessions/session_store.h"

namespace enfilade::server {

// What robots did in lifts. The cabin of a lift is a map of one level, which robots enter and leave on others, too.
struct LiftRides {
  std::set<MapId> cabins;  // in which robots came to another level
  // In a cabin, entered from a level that its map is not of: what such a session sees through the door is of that
  // level. Also those that follow it in the cabin.
  std::set<SessionId> from_elsewhere;
  // The session on another level that follows each, and the map that it is in by now.
  std::map<SessionId, std::pair<SessionId, MapId>> next;
  std::set<SessionId> going_on;  // sessions whose next one is not mapped yet
};

// By the sessions that are mapped and follow one on another level, and by the passages between them. Those that people
// have set count as none. `sessions`: oldest first.
absl::StatusOr<LiftRides> FindLiftRides(const DriveReader& reader, const std::vector<storage::Session>& sessions,
                                        const std::map<MapId, storage::Map>& maps);

}  // namespace enfilade::server
