// SPDX-License-Identifier: Apache-2.0
#include "core/slam/loops/last_pass.h"

#include <algorithm>
#include <limits>

#include "core/slam/loops/loop_candidates.h"
#include "core/slam/loops/loop_closer.h"

namespace enfilade::slam {
namespace {

constexpr std::size_t kMaxKeyframes = 3;  // of a pair

// The distance of a keyframe of `later`, in the map frame, to the nearest one of `earlier`.
double NearestTo(const FinishedSubmap& earlier, const Eigen::Vector2d& p_map) {
  const Eigen::Vector2d p = Inverse(earlier.T_map_submap) * p_map;
  double nearest = std::numeric_limits<double>::max();
  for (const SubmapNode& node : earlier.nodes) {
    nearest = std::min(nearest, (node.T_submap_node.translation() - p).squaredNorm());
  }
  return std::sqrt(nearest);
}

double Distance(const FinishedSubmap& earlier, const FinishedSubmap& later) {
  double nearest = std::numeric_limits<double>::max();
  for (const SubmapNode& node : later.nodes) {
    nearest = std::min(nearest, NearestTo(earlier, later.T_map_submap * node.T_submap_node.translation()));
  }
  return nearest;
}

LoopCandidate CandidateOf(const UnjoinedPair& pair, const LoopOptions& options) {
  LoopCandidate candidate;
  candidate.submap = pair.earlier;
  candidate.distance = pair.distance;
  candidate.seen_from_node = false;
  const double drifted = options.last_pass_widening * pair.drifted;
  candidate.half_width = std::min(options.search_base + options.drift_per_metre * drifted, options.max_search);
  candidate.half_angle = std::min(options.search_angle_base + options.yaw_drift_per_metre * drifted, M_PI);
  return candidate;
}

// Keyframes of `later`, those nearest to `earlier` first, each at least `spacing` from those before.
std::vector<SubmapNode> SelectKeyframes(const FinishedSubmap& earlier, const FinishedSubmap& later, double spacing) {
  std::vector<std::pair<double, SubmapNode>> sorted;
  for (const SubmapNode& node : later.nodes) {
    if (node.carried) continue;
    sorted.emplace_back(NearestTo(earlier, later.T_map_submap * node.T_submap_node.translation()), node);
  }
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<SubmapNode> selected;
  for (const auto& [distance, node] : sorted) {
    const bool is_near = std::any_of(selected.begin(), selected.end(), [&](const SubmapNode& other) {
      return (other.T_submap_node.translation() - node.T_submap_node.translation()).norm() < spacing;
    });
    if (!is_near) selected.push_back(node);
    if (selected.size() == kMaxKeyframes) break;
  }
  return selected;
}

// What a submap shows within `range` of a keyframe, m, in the keyframe's frame.
std::vector<Eigen::Vector2d> Around(const std::vector<Eigen::Vector2d>& points, const Pose2& T_submap_node,
                                    double range) {
  std::vector<Eigen::Vector2d> around;
  const Pose2 T_node_submap = Inverse(T_submap_node);
  for (const Eigen::Vector2d& point : points) {
    if ((point - T_submap_node.translation()).squaredNorm() > range * range) continue;
    around.push_back(T_node_submap * point);
  }
  return around;
}

}  // namespace

std::optional<UnjoinedPair> LastPass::Next(const MapperState& state) {
  if (!pairs_) FindPairs(state);
  while (!pairs_->empty()) {
    const UnjoinedPair pair = pairs_->back();
    pairs_->pop_back();
    if (tried_.emplace(pair.earlier, pair.later).second) return pair;
  }
  return std::nullopt;
}

void LastPass::FindPairs(const MapperState& state) {
  const LoopOptions& loop = options_.loop;
  pairs_.emplace();
  for (const auto& [later, submap] : state.finished) {
    if (state.is_existing_map(later) || submap.nodes.empty()) continue;
    const std::vector<double> lengths = DriftLengths(state, later);
    for (const auto& [earlier, other] : state.finished) {
      if (earlier + loop.min_submap_gap > later) break;
      if (state.is_existing_map(earlier) || other.nodes.empty()) continue;
      UnjoinedPair pair{earlier, later, 0.0, lengths[static_cast<std::size_t>(earlier)]};
      if (pair.drifted < loop.last_pass_length || tried_.contains({earlier, later})) continue;
      const double reach = loop.max_distance + CandidateOf(pair, loop).half_width;
      if ((submap.T_map_submap.translation() - other.T_map_submap.translation()).norm() >
          submap.extent + other.extent + reach) {
        continue;
      }
      pair.distance = Distance(other, submap);
      if (pair.distance <= reach) pairs_->push_back(pair);
    }
  }
  std::stable_sort(pairs_->begin(), pairs_->end(),
                   [](const UnjoinedPair& a, const UnjoinedPair& b) { return a.distance > b.distance; });
}

std::vector<LoopClosure> LastPass::Try(const MapperState& state, const UnjoinedPair& pair, SubmapCache& cache) const {
  const FinishedSubmap& earlier = state.finished.at(pair.earlier);
  const FinishedSubmap& later = state.finished.at(pair.later);
  const std::vector<Eigen::Vector2d> points = cache.GetGrid(pair.later, later).OccupiedPoints();
  const LoopCandidate candidate = CandidateOf(pair, options_.loop);
  std::vector<LoopClosure> closures;
  for (const SubmapNode& node : SelectKeyframes(earlier, later, options_.loop.min_agreeing_length)) {
    const Pose2 guess = Between(earlier.T_map_submap, later.T_map_submap * node.T_submap_node);
    LoopMatch match =
        MatchLoop(cache.Get(pair.earlier, earlier), Around(points, node.T_submap_node, options_.loop.last_pass_range),
                  guess, candidate, options_);
    closures.push_back(ToLoopClosure(state, closures.size(), pair.earlier, node.node, std::move(match)));
    if (closures.back().state != LoopClosureState::kAccepted) break;
  }
  return closures;
}

}  // namespace enfilade::slam
