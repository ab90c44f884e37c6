// SPDX-License-Identifier: Apache-2.0
#include "core/slam/mapper/policies.h"

#include <cmath>

namespace enfilade::slam {
namespace {

// A scan contradicts the map if enough of it falls on known ground and it does not fit.
bool Contradicts(const LocalMatch& match, const LocalMatchOptions& options) {
  return !match.good && match.agreement.known_share() >= options.min_matched_share;
}

}  // namespace

bool IsKeyframeDue(const Pose2& T_last_now, const KeyframeOptions& options) {
  return T_last_now.translation().norm() >= options.distance || std::abs(T_last_now.yaw) >= options.angle;
}

bool IsSubmapFull(const Submap& submap, const Pose2& T_submap_robot, const SubmapOptions& options) {
  return submap.own_nodes() >= options.max_keyframes || T_submap_robot.translation().norm() > options.max_extent;
}

TrackQuality Updated(const TrackQuality& quality, const LocalMatch& match, const LocalMatchOptions& options) {
  if (match.good) return {};
  return {quality.poor + 1, quality.contradicting + (Contradicts(match, options) ? 1 : 0)};
}

bool IsLost(const TrackQuality& quality, const QualityOptions& options) { return quality.poor >= options.lost_after; }

bool IsElsewhere(const TrackQuality& quality, const QualityOptions& options) {
  return quality.contradicting >= options.new_submap_after;
}

bool IsSolveDue(std::int64_t nodes, std::int64_t nodes_at_solve, bool urgent, const GraphOptions& options) {
  const double growth = urgent ? options.urgent_growth : options.growth;
  return static_cast<double>(nodes) >= static_cast<double>(nodes_at_solve) * (1.0 + growth);
}

bool MayInsert(const LocalMatch& match, const LocalMatchOptions& options) {
  return match.good || !Contradicts(match, options);
}

}  // namespace enfilade::slam
