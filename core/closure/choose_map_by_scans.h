// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/closure/door_knowledge.h"
#include "core/closure/enter_map.h"
#include "core/closure/judge_place.h"

namespace enfilade::closure {

// The known map that the robot's scans behind the door fit into.
struct ScanSearchResult {
  std::optional<Destination> found;
  std::vector<std::string> wait_for;  // display names of maps that are being mapped and that may turn out to be the one
  std::string reason;                 // why no map was found, to be appended to another reason; may be empty
};

// Which of knowledge.maps, all of them searched, the robot is in. None if two maps would do, or if the clouds or images
// of the very door (`compared`) contradict the scans. A map without a match is worth waiting for while sessions record
// in it (patience_live) or have yet to be mapped (patience).
ScanSearchResult ChooseMapByScans(const DoorKnowledge& knowledge, const std::vector<PlaceEvidence>& compared);

}  // namespace enfilade::closure
