// SPDX-License-Identifier: Apache-2.0
#include "core/prior/correction/wall_sight.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/prior/correction/wall_line.h"

namespace enfilade::prior {
namespace {

// The piece at a share of the wall's length, and its neighbours: points of the map's walls have gaps.
void Mark(std::vector<std::uint8_t>& pieces, double fraction) {
  const int count = static_cast<int>(pieces.size());
  const int piece = std::clamp(static_cast<int>(fraction * count), 0, count - 1);
  for (int i = std::max(0, piece - 1); i <= std::min(count - 1, piece + 1); ++i) {
    pieces[static_cast<std::size_t>(i)] = 1;
  }
}

// Zero: it has none.
Eigen::Vector2d DirectionOf(const WallPoint& wall) {
  return wall.straightness > kStraight ? wall.along : Eigen::Vector2d::Zero();
}

void MarkCompatible(const WallFace& line, const MapEvidence& evidence, std::vector<std::uint8_t>& pieces) {
  const Eigen::Vector2d way = line.to - line.from;
  const double length = way.norm();
  if (!(length > 0)) return;
  const Eigen::Vector2d along = way / length;
  for (const WallPoint& wall : evidence.walls) {
    const Eigen::Vector2d from = wall.point - line.from;
    const double at = along.dot(from);
    if (at < -kSeenDistance || at > length + kSeenDistance) continue;
    if (std::abs(along.x() * from.y() - along.y() * from.x()) > kSeenDistance) continue;
    const Eigen::Vector2d direction = DirectionOf(wall);
    if (direction.squaredNorm() > 0 && std::abs(direction.dot(along)) < std::cos(kParallel)) continue;
    Mark(pieces, at / length);
  }
}

WallSight SightOfWall(const WallFace& centre, const std::vector<WallSample>& samples, const MapEvidence& evidence) {
  const WallLine line = LikeliestLine(centre, samples, kSeenDistance / 2, evidence);
  const auto count = static_cast<double>(line.slots.size());
  std::vector<std::uint8_t> compatible(line.slots.size(), 0);
  MarkCompatible(centre, evidence, compatible);
  const double on_line = line.SupportedShare(0, 1);
  WallSight sight;
  for (std::size_t i = 0; i < line.slots.size(); ++i) {
    const Eigen::Vector2d middle = centre.from + (static_cast<double>(i) + 0.5) / count * (centre.to - centre.from);
    if (line.slots[i] == 0 && compatible[i] == 0 && evidence.GroundAt(middle) == Ground::kFree) {
      sight.contradicted_share += 1 / count;
    }
  }
  if (line.is_seen()) {
    sight.seen_share = on_line;
    if (on_line >= 0.5) sight.sight = Sight::kSeen;
    return sight;
  }
  // A wall that is shorter than walls may be off may be anywhere.
  const bool is_long = (centre.to - centre.from).norm() > kSeenDistance;
  const bool is_known = on_line + sight.contradicted_share >= 0.5;
  if (is_long && is_known && sight.contradicted_share > on_line) sight.sight = Sight::kContradicted;
  return sight;
}

}  // namespace

std::vector<WallSight> SightsOf(const std::vector<WallFace>& lines, const std::vector<WallFace>& faces,
                                const MapEvidence& evidence) {
  std::vector<std::vector<WallSample>> samples(lines.size());
  const FaceIndex index(faces, kSeenDistance);
  for (const WallPoint& wall : evidence.walls) {
    const auto nearest = index.Nearest(wall.point, DirectionOf(wall), kParallel, wall.open);
    if (!nearest) continue;
    const WallFace& face = faces[static_cast<std::size_t>(nearest->face)];
    if (const auto sample = SampleOf(wall.point, *nearest, face)) {
      samples[static_cast<std::size_t>(face.wall)].push_back(*sample);
    }
  }
  std::vector<WallSight> sights;
  for (std::size_t i = 0; i < lines.size(); ++i) sights.push_back(SightOfWall(lines[i], samples[i], evidence));
  return sights;
}

}  // namespace enfilade::prior
