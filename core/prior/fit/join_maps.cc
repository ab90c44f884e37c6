// SPDX-License-Identifier: Apache-2.0
#include "core/prior/fit/join_maps.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>

#include "core/base/status_macros.h"
#include "core/grid/overlay.h"
#include "core/prior/alignment/agreement.h"
#include "core/prior/alignment/refine.h"

namespace enfilade::prior {
namespace {

constexpr double kLeastStraight = 0.6;

// What has been seen, and the plan's walls elsewhere.
std::vector<WallFace> FacesAround(const MapEvidence& seen, const CorrectedPlan& corrected) {
  std::vector<WallFace> faces;
  for (const WallPoint& wall : seen.walls) {
    if (wall.straightness < kLeastStraight) continue;
    const Eigen::Vector2d half = seen.spacing * wall.along;
    faces.push_back({wall.point - half, wall.point + half, -1, wall.open});
  }
  for (const WallFace& face : corrected.faces()) {
    if (SightOf(seen, 0.5 * (face.from + face.to)) == Sight::kUnseen) faces.push_back(face);
  }
  return faces;
}

}  // namespace

Pose2 JoinByPlan(const MapEvidence& evidence, const PlanTransform& T_map_sheet, const PlanTransform& T_other_sheet) {
  const auto size = static_cast<double>(evidence.walls.size());
  const auto in_other = [&](const WallPoint& wall) { return T_other_sheet(ToSheet(T_map_sheet, wall.point)); };
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Vector2d mean_other = Eigen::Vector2d::Zero();
  for (const WallPoint& wall : evidence.walls) {
    mean += wall.point / size;
    mean_other += in_other(wall) / size;
  }
  double cosine = 0;
  double sine = 0;
  for (const WallPoint& wall : evidence.walls) {
    const Eigen::Vector2d from = wall.point - mean;
    const Eigen::Vector2d to = in_other(wall) - mean_other;
    cosine += from.dot(to);
    sine += from.x() * to.y() - from.y() * to.x();
  }
  const double yaw = std::atan2(sine, cosine);
  const Eigen::Vector2d shift = mean_other - Eigen::Rotation2Dd(yaw) * mean;
  return {shift.x(), shift.y(), yaw};
}

Pose2 RefineAmong(const MapEvidence& evidence, const MapEvidence& others, const CorrectedPlan& corrected,
                  const Pose2& T_frame_map) {
  const Pose2 T_map_frame = Inverse(T_frame_map);
  const PlanTransform start{Eigen::Rotation2Dd(T_map_frame.yaw).toRotationMatrix(), T_map_frame.translation()};
  const PlanTransform refined = Refine(FacesAround(others, corrected), evidence, start,
                                       {.model = TransformModel::kRigid, .widest = 1.0, .narrowest = 0.2});
  const double yaw = std::atan2(refined.linear(1, 0), refined.linear(0, 0));
  return Inverse(Pose2{refined.offset.x(), refined.offset.y(), yaw});
}

double ContradictedShare(const MapEvidence& map, const MapEvidence& other, const Pose2& T_other_map) {
  constexpr double kLeastCommon = 3.0;  // m
  double common = 0;
  double contradicted = 0;
  const auto add = [&](const MapEvidence& of, const MapEvidence& in, const Pose2& T_in_of) {
    for (const WallPoint& wall : of.walls) {
      if (wall.straightness < kLeastStraight) continue;  // furniture is moved
      const Eigen::Vector2d across = kSeenDistance * Eigen::Vector2d(-wall.along.y(), wall.along.x());
      const auto sight = [&](double side) { return SightOf(in, T_in_of * (wall.point + side * across)); };
      if (sight(0) == Sight::kUnseen) continue;
      common += of.spacing;
      // The other may have seen as far as the wall.
      const bool is_amid = sight(-1) == Sight::kContradicted && sight(1) == Sight::kContradicted;
      if (sight(0) == Sight::kContradicted && is_amid) contradicted += of.spacing;
    }
  };
  add(map, other, T_other_map);
  add(other, map, Inverse(T_other_map));
  return common < kLeastCommon ? 0 : contradicted / common;
}

absl::StatusOr<grid::OccupancyGrid> Overlaid(const std::vector<PlacedMap>& maps) {
  grid::OccupancyGrid all;
  for (const PlacedMap& one : maps) {
    grid::OccupancyGrid moved = *one.map;
    for (std::size_t i = 0; i < moved.cells.size(); ++i) {
      if (one.evidence->ground[i] == Ground::kUnknown) moved.cells[i] = grid::kUnknownCell;
    }
    moved.geometry.T_map_grid = one.T_frame_map * moved.geometry.T_map_grid;
    ENFILADE_ASSIGN_OR_RETURN(moved, grid::ResampleToLattice(moved, maps.front().map->geometry.resolution));
    ENFILADE_ASSIGN_OR_RETURN(all, grid::Overlay(all, moved));
  }
  return all;
}

}  // namespace enfilade::prior
