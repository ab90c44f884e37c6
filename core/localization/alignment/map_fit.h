// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "core/geometry/pose2.h"
#include "core/localization/alignment/alignable_map.h"

namespace enfilade::localization {

// A surface counts as on a wall within this distance, m.
constexpr double kOnWall = 0.15;

// Whether the ground before a surface point, at `T_map_point` in `map`, has been seen free there: both maps have then
// seen the same side of the wall.
bool IsSeenFromTheSameSide(const AlignableMap& map, const Pose2& T_map_points, const SurfacePoint& surface);

// What the surfaces of one map, at their place in another, say. m of wall.
struct SurfaceFit {
  double matched = 0.0;       // on walls of the other, seen from the same side
  double contradicted = 0.0;  // on its free ground

  double known() const { return matched + contradicted; }
  double share() const { return known() > 0.0 ? matched / known() : 0.0; }
};
SurfaceFit CompareSurfaces(const AlignableMap& map, const AlignableMap& other, const Pose2& T_map_other);

// How well two maps fit at a place, both ways.
struct MapFit {
  SurfaceFit b_in_a;
  SurfaceFit a_in_b;

  double matched() const { return b_in_a.matched + a_in_b.matched; }
  double contradicted() const { return b_in_a.contradicted + a_in_b.contradicted; }
  double share() const {
    const double known = matched() + contradicted();
    return known > 0.0 ? matched() / known : 0.0;
  }
};
MapFit CompareMaps(const AlignableMap& a, const AlignableMap& b, const Pose2& T_a_b);

// The ground that both maps have seen free.
struct CommonGround {
  double area = 0.0;                                 // m^2
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();  // m, of it the point nearest to its centroid, in a's frame
};
CommonGround CommonGroundOf(const AlignableMap& a, const AlignableMap& b, const Pose2& T_a_b);

}  // namespace enfilade::localization
