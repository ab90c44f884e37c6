// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "client/simulator/campus/campus.h"
#include "core/prior/formats/building_file.h"

namespace enfilade::simulator {

// The campus of a building of Open-RMF: its walls, its doors (open), its lifts. Gaps in walls as wide as doors are
// doors, too, if they divide areas (LEVEL-gap1, ...). Areas are what walls and closed doors would divide: pieces of at
// least 2 m^2, LEVEL-1, LEVEL-2, ... from the largest; what is open to the outside is none. Levels lie above each other
// as their lifts say. The robot "robot" visits every area that it can reach, one level after the other by lift, and
// returns to its start. INVALID_ARGUMENT: it has no areas, or is larger than 200 m.
absl::StatusOr<Campus> CampusOf(const prior::Building& building);

}  // namespace enfilade::simulator
