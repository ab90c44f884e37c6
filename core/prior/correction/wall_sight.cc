// SPDX-License-Identifier: Apache-2.0
#include "core/prior/correction/wall_sight.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace enfilade::prior {
namespace {

constexpr double kPieceLength = 0.2;  // m, at most

// What was found of each piece of a wall.
struct Pieces {
  std::vector<std::uint8_t> seen;
  std::vector<std::uint8_t> compatible;  // a wall nearby may be this one
};

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

}  // namespace

std::vector<WallSight> SightsOf(const std::vector<WallFace>& lines, const std::vector<WallFace>& faces,
                                const MapEvidence& evidence) {
  std::vector<Pieces> found(lines.size());
  const double piece = std::max(kPieceLength, evidence.spacing);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto count = static_cast<std::size_t>(std::max(1.0, std::ceil((lines[i].to - lines[i].from).norm() / piece)));
    found[i] = {std::vector<std::uint8_t>(count, 0), std::vector<std::uint8_t>(count, 0)};
    MarkCompatible(lines[i], evidence, found[i].compatible);
  }
  const FaceIndex index(faces, kSeenDistance);
  for (const WallPoint& wall : evidence.walls) {
    const auto nearest = index.Nearest(wall.point, DirectionOf(wall), kParallel, wall.open);
    if (!nearest) continue;
    const int of = faces[static_cast<std::size_t>(nearest->face)].wall;
    Mark(found[static_cast<std::size_t>(of)].seen, nearest->fraction);
  }
  std::vector<WallSight> sights(lines.size());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto count = static_cast<double>(found[i].seen.size());
    for (std::size_t k = 0; k < found[i].seen.size(); ++k) {
      const Eigen::Vector2d middle =
          lines[i].from + (static_cast<double>(k) + 0.5) / count * (lines[i].to - lines[i].from);
      if (found[i].seen[k] != 0) {
        sights[i].seen_share += 1 / count;
      } else if (found[i].compatible[k] == 0 && evidence.GroundAt(middle) == Ground::kFree) {
        sights[i].contradicted_share += 1 / count;
      }
    }
    if (sights[i].contradicted_share > 0.5) sights[i].sight = Sight::kContradicted;
    if (sights[i].seen_share >= 0.5) sights[i].sight = Sight::kSeen;
  }
  return sights;
}

}  // namespace enfilade::prior
