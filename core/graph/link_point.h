// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/graph/link_point_kind.h"

namespace enfilade::graph {

// The numbers of these enums are in the database: never reuse one.
// Whether a robot can pass. Chains of poses use a place in any state.
enum class PassageState : std::int16_t { kOpen = 1, kClosed = 2, kBlocked = 3 };
// Whether the graph uses a link point.
enum class LinkPointUse : std::int16_t {
  kUsed = 1,
  kSwitchedOff = 2,  // by the optimisation's chi-squared gate: contradicts the others
  kSuspended = 3,    // by a person
};

// A place as seen from one map.
struct Anchor {
  MapId map = {};
  Pose2 T_map_place = {};  // m, rad
  // In (x, y, yaw) of T_map_place: m^2, m rad, rad^2. Symmetric, positive semi-definite.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();

  friend bool operator==(const Anchor&, const Anchor&) = default;
};

// The default if nothing better is known: map_manager's initial_variance_x, _y, _theta = 0.003 m^2, 0.003 m^2, 0.003
// rad^2 per map-to-map transform, that is, of its two anchors together.
inline Eigen::Matrix3d DefaultTransformCovariance() { return Eigen::Vector3d(0.003, 0.003, 0.003).asDiagonal(); }
// The share of each of the two anchors. Two such anchors compose to the default if the place is at the maps' origins;
// farther out the yaw variances add to the position.
inline Eigen::Matrix3d DefaultAnchorCovariance() { return 0.5 * DefaultTransformCovariance(); }

// One physical place (a door, a lift, a ramp) where maps meet.
struct LinkPoint {
  LinkPointId id = {};
  LinkPointKind kind = LinkPointKind::kDoor;
  // At most one per map, in order of creation. With one anchor this is a candidate, seen from one side; with two or
  // more a link point. A lift can join three and more maps.
  std::vector<Anchor> anchors = {};
  MapId direction = {};  // the map that was entered when it was created; empty: unknown
  int difficulty = 0;    // 0: none, greater: harder to pass
  std::string tag = {};  // free text
  PassageState state = PassageState::kOpen;
  // The end of `state`; afterwards the place counts as open. Unset: no end.
  std::optional<TimeNs> state_valid_until = {};
  LinkPointUse use = LinkPointUse::kUsed;
  bool pinned = false;             // people have placed it: surveys neither move nor remove it
  std::int64_t graph_version = 0;  // of the site at its last change

  bool is_candidate() const { return anchors.size() < 2; }
  // The anchor in `map`, or null.
  const Anchor* FindAnchor(const MapId& map) const {
    for (const Anchor& anchor : anchors) {
      if (anchor.map == map) return &anchor;
    }
    return nullptr;
  }

  friend bool operator==(const LinkPoint&, const LinkPoint&) = default;
};

}  // namespace enfilade::graph
