// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <set>
#include <vector>

#include "tests/fakes/in_memory_database.h"

namespace enfilade::testing {

// The floors that a link point joins.
std::set<int> LevelsOf(const SiteRows& site, const storage::StoredLinkPoint& link_point);
// All link points of the graph, by id.
std::vector<storage::StoredLinkPoint> ListLinkPoints(const GraphRows& graph);
// Places the link point in the world, and through it the maps and link points that have no place yet.
void PlaceLinkPoint(GraphRows& graph, std::int64_t version, const LinkPointId& link_point);
// Deletes a map from the graph, with the link points that join no two maps without it.
void RemoveMap(InMemoryDatabase::Access& access, const SiteId& site, const MapId& map, std::int64_t version);

}  // namespace enfilade::testing
