// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "core/base/environment.h"
#include "core/base/ids.h"
#include "storage/maps/map_store.h"
#include "storage/sessions/session_store.h"

namespace enfilade::server {

// The sessions of one robot that follow each other through doors, in order.
using StoredDrive = std::vector<const storage::Session*>;

// It is in a map, all its records are mapped, and its doors are judged. Cut before that, what lies behind a door that
// it was left by would count as its side of the door when that is judged.
bool IsSettled(const storage::Session& session);

// Its robot is recording, or it waits for being mapped and judged.
bool IsUnderWay(const storage::Session& session);

// The drives of one level, as far as they are settled and retention has kept their records, in the order of their first
// sessions in `sessions`. The pieces of a session that was cut are one drive, however old they are. Of two sessions
// that follow the same one, the first continues its drive and the other begins one.
std::vector<StoredDrive> DrivesOn(int level, const std::vector<storage::Session>& sessions,
                                  const std::map<MapId, storage::Map>& maps);

// What the map of a drive depends on but for the drives before it. It stays the same when its sessions are cut or
// moved.
std::string KeyOf(const StoredDrive& drive, Environment environment);

// Stays the same when the drive goes on, too.
std::string BeginningOf(const StoredDrive& drive, Environment environment);

// How many of the drive's sessions, from its beginning on, have the records of `key`: the key of what it was before it
// went on. 0: it was another drive.
std::size_t CountSessionsOf(const std::string& key, const StoredDrive& drive, Environment environment);

}  // namespace enfilade::server
