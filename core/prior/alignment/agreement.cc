// SPDX-License-Identifier: Apache-2.0
#include "core/prior/alignment/agreement.h"

#include <cmath>

namespace enfilade::prior {
namespace {

constexpr double kStep = 0.2;  // m between samples of the plan's walls

}  // namespace

Sight SightOf(const MapEvidence& evidence, const Eigen::Vector2d& point) {
  const std::optional<std::size_t> cell = evidence.CellOf(point);
  if (!cell) return Sight::kUnseen;
  if (evidence.wall_distance[*cell] <= kSeenDistance) return Sight::kSeen;
  return evidence.ground[*cell] == Ground::kFree ? Sight::kContradicted : Sight::kUnseen;
}

Agreement Compare(const FaceIndex& walls, const MapEvidence& evidence) {
  Agreement agreement;
  double weight = 0;
  for (const WallPoint& wall : evidence.walls) {
    weight += wall.straightness;
    const Eigen::Vector2d along = wall.straightness > kStraight ? wall.along : Eigen::Vector2d::Zero();
    const auto nearest = walls.Nearest(wall.point, along, kParallel);
    if (!nearest) continue;
    const double d = nearest->distance / kNearSigma;
    agreement.nearness += wall.straightness * std::exp(-0.5 * d * d);
    if (nearest->distance > kExplainedDistance) continue;
    agreement.explained += wall.straightness;
    agreement.explained_length += evidence.spacing;
  }
  if (weight > 0) {
    agreement.explained /= weight;
    agreement.nearness /= weight;
  }
  for (const WallFace& face : walls.faces()) {
    const Eigen::Vector2d way = face.to - face.from;
    const int pieces = std::max(1, static_cast<int>(std::ceil(way.norm() / kStep)));
    const double length = way.norm() / pieces;
    for (int i = 0; i < pieces; ++i) {
      switch (SightOf(evidence, face.from + (i + 0.5) / pieces * way)) {
        case Sight::kSeen:
          agreement.seen_length += length;
          break;
        case Sight::kContradicted:
          agreement.contradicted_length += length;
          break;
        case Sight::kUnseen:
          break;
      }
    }
  }
  return agreement;
}

}  // namespace enfilade::prior
