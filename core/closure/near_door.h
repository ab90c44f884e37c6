// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/closure/door_knowledge.h"
#include "core/graph/graph_snapshot.h"
#include "core/graph/search_radius.h"

namespace enfilade::closure {

// What a door may be near to by the poses of the graph's solution, so that chains of link points, which say it more
// exactly but cost a search, are followed to few maps only. All functions need knowledge.map, T_map_door and
// T_map_robot.

graph::SearchRadiusOptions RadiusOptions(const DoorClosureOptions& options);
bool IsOnEnteredLevel(const DoorKnowledge& knowledge, const MapId& map);
// Whether the anchor is in another map than the session's, on the entered level.
bool MayBeEntered(const DoorKnowledge& knowledge, const graph::Anchor& anchor);

// Link points that the search for places looks at, by id. Needs knowledge.passed.
std::vector<const graph::LinkPoint*> FindNear(const DoorKnowledge& knowledge);
// Other maps on the entered level that the search for maps looks at, by id.
std::vector<const graph::MapInGraph*> FindMapsNear(const DoorKnowledge& knowledge);

}  // namespace enfilade::closure
