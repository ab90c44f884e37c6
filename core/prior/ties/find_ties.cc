// SPDX-License-Identifier: Apache-2.0
#include "core/prior/ties/find_ties.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "core/prior/alignment/fitted_line.h"
#include "core/prior/ties/plan_frame.h"
#include "core/prior/ties/shafts_of_plan.h"

namespace enfilade::prior {
namespace {

constexpr double kReach = 0.5;             // m, from a map's wall to the plan's
constexpr double kLeastStraight = 0.6;     // as for corrections
constexpr double kMostOff = 0.15;          // m, from the line
constexpr double kLeastLength = 0.8;       // m
constexpr double kAcrossSigma = 0.05;      // m: of a map's walls, and of the drawn thickness
constexpr double kUnknownFaceSigma = 0.1;  // m: the plan draws a line, and robots see one face or the other
constexpr double kLeastYawSigma = 0.5 * kDegree;
constexpr double kStretchSigma = 0.04;
constexpr double kLeastCornerSigma = 0.05;  // m

// Of the walls of a map that were seen on one face of the plan.
struct SeenFace {
  std::vector<Eigen::Vector2d> points;  // m, the map's frame
  double fractions = 0;                 // sum, of the way along the face
};

// Without what is off the line.
std::optional<FittedLine> Fit(std::vector<Eigen::Vector2d> points) {
  if (points.size() < 2) return std::nullopt;
  const FittedLine first = FitLine(points);
  std::erase_if(points, [&](const Eigen::Vector2d& point) { return std::abs(first.OffsetOf(point)) > kMostOff; });
  if (points.size() < 2) return std::nullopt;
  const FittedLine line = FitLine(points);
  return line.length() >= kLeastLength ? std::optional(line) : std::nullopt;
}

// By face.
std::map<int, SeenFace> SeenFaces(const FaceIndex& faces, const MapOfPlan& map) {
  const Eigen::Rotation2Dd turn(map.T_plan_map.yaw);
  std::map<int, SeenFace> seen;
  for (const WallPoint& wall : map.evidence->walls) {
    if (wall.straightness < kLeastStraight) continue;
    const auto nearest = faces.Nearest(map.T_plan_map * wall.point, turn * wall.along, kParallel, turn * wall.open);
    // Beyond a wall's end there may be anything.
    if (!nearest || nearest->fraction <= 0 || nearest->fraction >= 1) continue;
    SeenFace& face = seen[nearest->face];
    face.points.push_back(wall.point);
    face.fractions += nearest->fraction;
  }
  return seen;
}

}  // namespace

graph::PlanTies FindTies(const PlanGraph& plan, const PlanTransform& T_plan_sheet, const CorrectedPlan& corrected,
                         const std::vector<MapOfPlan>& maps) {
  const FaceIndex index(corrected.faces(), kReach);
  struct Sighting {
    const MapOfPlan* map;
    int wall;
    double fraction;
    graph::WallSighting line;
  };
  std::vector<Sighting> sightings;
  std::vector<char> is_seen(plan.walls.size(), 0);
  for (const MapOfPlan& map : maps) {
    const Eigen::Rotation2Dd to_map(-map.T_plan_map.yaw);
    for (const auto& [number, seen] : SeenFaces(index, map)) {
      const std::optional<FittedLine> line = Fit(seen.points);
      if (!line) continue;
      const WallFace& face = index.faces()[static_cast<std::size_t>(number)];
      const Eigen::Vector2d way = to_map * (face.to - face.from);
      const Eigen::Vector2d along = way.dot(line->along) < 0 ? Eigen::Vector2d(-line->along) : line->along;
      const PlanWall& wall = plan.walls[static_cast<std::size_t>(face.wall)];
      const bool has_faces = !face.outward.isZero();
      Eigen::Vector2d middle = line->middle;
      if (has_faces) {
        const Eigen::Vector2d normal(-along.y(), along.x());
        const double side = normal.dot(to_map * face.outward) < 0 ? -1.0 : 1.0;
        middle -= side * 0.5 * wall.thickness * T_plan_sheet.scale() * normal;
      }
      is_seen[static_cast<std::size_t>(face.wall)] = 1;
      sightings.push_back({&map,
                           face.wall,
                           seen.fractions / static_cast<double>(seen.points.size()),
                           {.map = map.id,
                            .T_map_line = {middle.x(), middle.y(), std::atan2(along.y(), along.x())},
                            .length = line->length(),
                            .across_sigma = has_faces ? kAcrossSigma : kUnknownFaceSigma,
                            .yaw_sigma = std::max(kLeastYawSigma, kAcrossSigma / line->length())}});
    }
  }
  PlanFrame frame = FrameOf(plan, T_plan_sheet, WithWallsOfShafts(plan, T_plan_sheet, is_seen));
  graph::PlanTies ties;
  ties.corner_sigma = std::max(kLeastCornerSigma, corrected.corner_sigma());
  ties.stretch_sigma = kStretchSigma;
  for (Sighting& sighting : sightings) {
    sighting.line.strut = frame.strut_of_wall[static_cast<std::size_t>(sighting.wall)];
    if (sighting.line.strut < 0) continue;  // the wall has no length
    const graph::PlanStrut& strut = frame.struts[static_cast<std::size_t>(sighting.line.strut)];
    const double length =
        (frame.corners[static_cast<std::size_t>(strut.to)] - frame.corners[static_cast<std::size_t>(strut.from)])
            .norm();
    sighting.line.along = (sighting.fraction - 0.5) * length;
    ties.sightings.push_back(std::move(sighting.line));
  }
  for (const MapOfPlan& map : maps) {
    const bool has_seen = std::any_of(ties.sightings.begin(), ties.sightings.end(),
                                      [&](const graph::WallSighting& sighting) { return sighting.map == map.id; });
    if (has_seen) ties.maps.push_back({map.id, map.T_plan_map});
  }
  std::sort(ties.maps.begin(), ties.maps.end(), [](const auto& a, const auto& b) { return a.map < b.map; });
  ties.shafts = NamedShafts(plan, T_plan_sheet, frame);
  ties.corners = std::move(frame.corners);
  ties.struts = std::move(frame.struts);
  return ties;
}

}  // namespace enfilade::prior
