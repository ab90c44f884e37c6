// SPDX-License-Identifier: Apache-2.0
#include "core/closure/choose_map_by_scans.h"

#include <algorithm>
#include <utility>

#include "core/closure/joined_anchors.h"
#include "core/closure/known_places.h"
#include "core/closure/pose_gate.h"
#include "fmt/format.h"

namespace enfilade::closure {
namespace {

// The place of the map `there` that the robot came by, if it is known: preferably one that joins both maps.
const graph::LinkPoint* FindPlaceOfDoor(const DoorKnowledge& knowledge, const MapId& there,
                                        const PoseWithCovariance& T_there_door) {
  const graph::LinkPoint* found = nullptr;
  for (const graph::LinkPoint* link_point : knowledge.graph->ListLinkPointsIn(there)) {
    const graph::Anchor* anchor = link_point->FindAnchor(there);
    if (anchor == nullptr || link_point->use == graph::LinkPointUse::kSuspended) continue;
    if (link_point->is_candidate() && knowledge.redundant.contains(link_point->id)) continue;
    if (!IsDoorOf(*link_point, *anchor, T_there_door, knowledge.options)) continue;
    if (link_point->FindAnchor(knowledge.map->id) != nullptr) return link_point;
    if (found == nullptr || found->is_candidate()) found = link_point;
  }
  return found;
}

// Does the evidence of the door itself, as the destination has it, contradict the scans? It does if its cloud is of
// another place, or has the robot elsewhere than the scans.
bool Contradicts(const PlaceEvidence& evidence, const Destination& to, const DoorClosureOptions& options) {
  if (to.link_point == nullptr || evidence.link_point != to.link_point->id || evidence.map != to.map) return false;
  if (!evidence.clouds) return false;
  if (evidence.clouds->agree) {
    return PoseChiSquared(evidence.clouds->T_map_robot, to.T_map_robot, options.pose_sigma, options.pose_yaw_sigma) >
           Gate(options);
  }
  return evidence.clouds->inlier_share < options.contradicting_share || (evidence.images && !evidence.images->agree);
}

bool IsWorthWaitingFor(const ScanEvidence& scans, const DoorKnowledge& knowledge) {
  return (scans.recording && knowledge.waited < knowledge.options.patience_live) ||
         (scans.mapping && knowledge.waited < knowledge.options.patience);
}

Destination ToDestination(const DoorKnowledge& knowledge, const SearchedMap& searched) {
  const ScanLocation& location = searched.scans->location;
  Destination to{.map = searched.map->id,
                 .link_point = nullptr,
                 .T_map_robot = location.T_map_robot,
                 .reason = "the scans show where the robot is: " + location.reason};
  const graph::Anchor door =
      JoinAtDoor(knowledge.map->id, knowledge.T_map_robot->pose, *knowledge.T_map_door, to.map, to.T_map_robot).there;
  to.link_point = FindPlaceOfDoor(knowledge, to.map, {door.T_map_place, door.covariance});
  return to;
}

}  // namespace

ScanSearchResult ChooseMapByScans(const DoorKnowledge& knowledge, const std::vector<PlaceEvidence>& compared) {
  ScanSearchResult result;
  std::vector<Destination> found;
  for (const SearchedMap& searched : *knowledge.maps) {
    const std::string& name = searched.map->display_name;
    if (!searched.scans->location.accepted) {
      if (IsWorthWaitingFor(*searched.scans, knowledge)) result.wait_for.push_back(name);
      result.reason += fmt::format("; by its scans not in \"{}\": {}", name, searched.scans->location.reason);
      continue;
    }
    Destination to = ToDestination(knowledge, searched);
    const bool contradicted = std::any_of(compared.begin(), compared.end(), [&](const PlaceEvidence& evidence) {
      return Contradicts(evidence, to, knowledge.options);
    });
    if (contradicted) {
      result.reason +=
          fmt::format("; its scans place it in \"{}\", but what was seen of the door contradicts it", name);
      continue;
    }
    found.push_back(std::move(to));
  }
  if (found.size() == 1) result.found = found.front();
  if (found.size() > 1) {
    result.reason += fmt::format("; its scans fit into {} maps", found.size());
    for (const Destination& to : found) result.reason += fmt::format("; {}: {}", to.map.value(), to.reason);
  }
  return result;
}

}  // namespace enfilade::closure
