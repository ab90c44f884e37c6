// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/prior/alignment/map_evidence.h"
#include "core/prior/alignment/wall_faces.h"

namespace enfilade::prior {

// What a map says of a piece of a plan's wall.
enum class Sight : std::uint8_t {
  kUnseen,        // the map does not know the place
  kSeen,          // it has a wall there
  kContradicted,  // it has free ground there
};

// How well a plan at its place fits a map.
struct Agreement {
  double explained = 0;         // share of the map's walls that lie on walls of the plan, by straightness
  double nearness = 0;          // the same, softly: the mean of exp(-d^2 / (2 kNearSigma^2))
  double explained_length = 0;  // m
  double seen_length = 0;       // m of the plan's walls
  double contradicted_length = 0;

  // Of what the map knows of the plan's walls.
  double contradicted() const {
    const double known = seen_length + contradicted_length;
    return known > 0 ? contradicted_length / known : 0;
  }
};

constexpr double kExplainedDistance = 0.2;  // m
constexpr double kNearSigma = 0.3;          // m
constexpr double kSeenDistance = 0.4;       // m
constexpr double kStraight = 0.8;           // from this straightness on the map knows its wall's direction
constexpr double kParallel = 0.35;          // rad; walls of straight surroundings must have the same direction

// `point`: of a wall of the plan, in the map's frame.
Sight SightOf(const MapEvidence& evidence, const Eigen::Vector2d& point);

// `walls`: the plan's faces in the map's frame.
Agreement Compare(const FaceIndex& walls, const MapEvidence& evidence);

}  // namespace enfilade::prior
