// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/prior/alignment/map_evidence.h"
#include "core/prior/alignment/wall_faces.h"

namespace enfilade::prior {

// A place where the map has something that may be a wall of the plan.
struct WallSample {
  double at = 0;      // m, along the wall's centre line from its `from`
  double across = 0;  // m, from the centre line, to its left: where the centre line would have to be
};

// `nearest`: to the point, on `face` of the wall. None beyond the wall's ends, where there may be anything.
std::optional<WallSample> SampleOf(const Eigen::Vector2d& point, const NearestFace& nearest, const WallFace& face);

// What a map says of a wall if its centre line is moved across itself, at each end by another amount.
struct WallLine {
  double from = 0;  // m, to the left
  double to = 0;
  double supported = 0;             // m of it that samples lie on
  double contradicted = 0;          // m of it in free ground
  std::vector<std::uint8_t> slots;  // equal parts of it, about 0.2 m long: whether samples lie on each

  double AcrossAt(double fraction) const { return from + fraction * (to - from); }
  // Of a part of its length; both from 0 to 1.
  double SupportedShare(double begin, double end) const;
  bool is_seen() const { return supported > contradicted; }
};

constexpr double kOnLine = 0.1;  // m: samples so near to a line lie on it

// The straight line that explains the samples best, because a wall is straight and is seen as a whole. What stands
// before a wall or crosses it lies on one line with it for a short way only, and the rest of that line is in free
// ground. `reach`: m, how far its ends are off, about; at most twice as far. Without samples: the line as it is.
WallLine LikeliestLine(const WallFace& centre, const std::vector<WallSample>& samples, double reach,
                       const MapEvidence& evidence);

}  // namespace enfilade::prior
