// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/passage_location.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/base/status_macros.h"
#include "core/closure/joined_anchors.h"
#include "core/closure/known_places.h"
#include "core/closure/pose_gate.h"
#include "core/closure/scan_location.h"
#include "core/graph/global_pose.h"
#include "core/graph/search_radius.h"
#include "fmt/format.h"
#include "server/app/closure/known_scans.h"

namespace enfilade::server {
namespace {

// A known map, and where the graph has the robot in it.
struct Predicted {
  const graph::MapInGraph* map = nullptr;
  PoseWithCovariance T_map_robot;
};

// Those with a link point within the search radius of it.
absl::StatusOr<std::vector<Predicted>> FindMaps(const PassageScene& passage, const graph::TransformsTo& to_this) {
  const graph::GraphSnapshot& graph = passage.graph.graph();
  const int level = passage.report.entered_level.value_or(passage.map.level);
  std::vector<Predicted> maps;
  for (const graph::MapInGraph* map : graph.ListMaps()) {
    if (map->id == passage.map.id || map->level != level) continue;
    ENFILADE_ASSIGN_OR_RETURN(const auto transform, to_this.Find(map->id));
    if (!transform) continue;  // scans alone do not tell one room from another
    const PoseWithCovariance robot = Compose(transform->T_a_b, passage.T_map_robot);
    double nearest = std::numeric_limits<double>::infinity();
    for (const int link_point : graph.map_node(graph.MapSlot(map->id)).link_points) {
      const graph::Anchor& anchor = *graph.link_point_node(link_point).link_point->FindAnchor(map->id);
      nearest = std::min(nearest, (anchor.T_map_place.translation() - robot.pose.translation()).norm());
    }
    const closure::DoorClosureOptions& options = passage.options;
    if (nearest <= graph::SearchRadius(robot.covariance, {options.search_base, options.search_factor})) {
      maps.push_back({map, robot});
    }
  }
  return maps;
}

// The place of the map that the robot came by, if it is known: one that joins both maps first.
const graph::LinkPoint* FindSeen(const PassageScene& passage, const MapId& there,
                                 const PoseWithCovariance& T_there_door) {
  const graph::LinkPoint* found = nullptr;
  for (const graph::LinkPoint* link_point : passage.graph.graph().ListLinkPoints()) {
    const graph::Anchor* anchor = link_point->FindAnchor(there);
    if (anchor == nullptr || link_point->use == graph::LinkPointUse::kSuspended) continue;
    if (link_point->is_candidate() && passage.excluded.contains(link_point->id)) continue;
    if (!closure::IsDoorOf(*link_point, *anchor, T_there_door, passage.options)) continue;
    if (link_point->FindAnchor(passage.map.id) != nullptr) return link_point;
    if (found == nullptr || found->is_candidate()) found = link_point;
  }
  return found;
}

// What was seen of the door itself, from the map that the scans say it leads into: a cloud that is of another place, or
// that has the robot elsewhere than the scans have it.
bool SpeaksAgainst(const closure::PlaceEvidence& evidence, const Destination& to,
                   const closure::DoorClosureOptions& options) {
  if (to.link_point == nullptr || evidence.link_point != to.link_point->id || evidence.map != to.map) return false;
  if (!evidence.clouds) return false;
  if (evidence.clouds->agree) {
    return closure::PoseChiSquared(evidence.clouds->T_map_robot, to.T_map_robot, options.pose_sigma,
                                   options.pose_yaw_sigma) > closure::Gate(options);
  }
  return evidence.clouds->inlier_share < options.contradicting_share || (evidence.images && !evidence.images->agree);
}

bool MayWait(const KnownScans& known, const PassageScene& passage) {
  return (known.recording && passage.waited < passage.options.patience_live) ||
         (known.mapping && passage.waited < passage.options.patience);
}

}  // namespace

absl::StatusOr<PassageLocation> LocatePassage(const storage::CallContext& context, const PassageScene& passage,
                                              const graph::TransformsTo& to_this,
                                              const std::vector<closure::PlaceEvidence>& compared) {
  PassageLocation location;
  const std::vector<Eigen::Vector2d> points =
      closure::PointsBehind(passage.scene.ScansBetween(passage.report.door_time, passage.report.time),
                            passage.T_map_door.pose, passage.T_map_robot.pose);
  if (points.empty()) return location;
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<Predicted> maps, FindMaps(passage, to_this));
  std::vector<Destination> found;
  for (const Predicted& one : maps) {
    ENFILADE_RETURN_IF_ERROR(passage.go_on());
    ENFILADE_ASSIGN_OR_RETURN(const KnownScans known,
                              ReadKnownScans(context, passage, one.map->id, one.T_map_robot.pose));
    const closure::ScanLocation located = closure::LocateByScans(known.scans, points, one.T_map_robot, passage.options);
    if (!located.accepted) {
      if (MayWait(known, passage)) location.wait_for += fmt::format(" \"{}\"", one.map->display_name);
      location.reason += fmt::format("; by its scans not in \"{}\": {}", one.map->display_name, located.reason);
      continue;
    }
    Destination to{one.map->id, nullptr, located.T_map_robot, "the scans show where the robot is: " + located.reason};
    const graph::Anchor door =
        closure::JoinAtDoor(passage.map.id, passage.T_map_robot.pose, passage.T_map_door, to.map, to.T_map_robot).there;
    to.link_point = FindSeen(passage, to.map, {door.T_map_place, door.covariance});
    if (std::any_of(compared.begin(), compared.end(), [&](const closure::PlaceEvidence& evidence) {
          return SpeaksAgainst(evidence, to, passage.options);
        })) {
      location.reason += fmt::format("; its scans place it in \"{}\", but what was seen of the door contradicts it",
                                     one.map->display_name);
      continue;
    }
    found.push_back(std::move(to));
  }
  if (found.size() == 1) location.found = found.front();
  if (found.size() > 1) {
    location.reason += fmt::format("; its scans fit into {} maps", found.size());
    for (const Destination& to : found) location.reason += fmt::format("; {}: {}", to.map.value(), to.reason);
  }
  return location;
}

}  // namespace enfilade::server
