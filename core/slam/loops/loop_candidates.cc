// SPDX-License-Identifier: Apache-2.0
#include "core/slam/loops/loop_candidates.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

namespace enfilade::slam {
namespace {

// For an existing map, which has no keyframes: the distance to the box of its known cells.
double NearestKeyframe(const FinishedSubmap& submap, const Pose2& T_map_node) {
  const Eigen::Vector2d p = (Inverse(submap.T_map_submap) * T_map_node).translation();
  if (submap.nodes.empty()) return submap.known.exteriorDistance(p);
  double nearest = std::numeric_limits<double>::max();
  for (const SubmapNode& node : submap.nodes) {
    nearest = std::min(nearest, (node.T_submap_node.translation() - p).squaredNorm());
  }
  return std::sqrt(nearest);
}

// The last nodes from which a submap was tried: with any result, and with success.
struct LastTried {
  std::int64_t any = std::numeric_limits<std::int64_t>::min() / 2;
  std::int64_t accepted = std::numeric_limits<std::int64_t>::min() / 2;
};

// Until the robot has been found in the existing map, the search must also cover the uncertainty of the entry.
void WidenByEntry(const MapperState& state, LoopCandidate& candidate) {
  candidate.is_entry = !state.joined.contains(0);
  if (!candidate.is_entry) return;
  const EntryReach reach = ReachOf(*state.entry);
  candidate.half_width += reach.translation;
  candidate.half_angle = std::min(candidate.half_angle + reach.yaw, M_PI);
}

}  // namespace

std::vector<double> DriftLengths(const MapperState& state, std::int64_t from) {
  std::vector<double> own;  // from each submap to the next
  own.reserve(state.finished.size());
  for (const auto& [id, submap] : state.finished) own.push_back(submap.length);
  std::vector<double> lengths(own.size() + 1, std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, std::int64_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  const auto reach = [&](std::int64_t submap, double length) {
    double& best = lengths[static_cast<std::size_t>(submap)];
    if (length >= best) return;
    best = length;
    open.emplace(length, submap);
  };
  reach(from, 0.0);
  while (!open.empty()) {
    const auto [length, submap] = open.top();
    open.pop();
    const auto index = static_cast<std::size_t>(submap);
    if (length > lengths[index]) continue;
    if (index < own.size()) reach(submap + 1, length + own[index]);
    if (index > 0) reach(submap - 1, length + own[index - 1]);
    const auto joined = state.joined.find(submap);
    if (joined == state.joined.end()) continue;
    for (const std::int64_t other : joined->second) reach(other, length);
  }
  return lengths;
}

std::vector<LoopCandidate> SelectLoopCandidates(const MapperState& state, const SlamNode& node,
                                                const LoopOptions& options) {
  std::vector<LoopCandidate> candidates;
  if (state.finished.empty()) return candidates;
  std::map<std::int64_t, LastTried> tried;
  for (auto it = state.loop_closures.rbegin(); it != state.loop_closures.rend(); ++it) {  // the latest first
    const LoopClosure& closure = it->second;
    if (node.id - closure.node > options.accepted_spacing) break;
    if (node.id - closure.node < options.attempt_interval) return candidates;
    LastTried& last = tried[closure.submap];
    last.any = std::max(last.any, closure.node);
    if (closure.state != LoopClosureState::kAccepted) continue;
    last.accepted = std::max(last.accepted, closure.node);
    if (node.id - closure.node < options.closure_spacing) return candidates;
  }
  const std::vector<double> lengths = DriftLengths(state, node.submap);
  for (const auto& [id, submap] : state.finished) {
    const bool is_existing_map = state.is_existing_map(id);
    if (is_existing_map && submap.known.isEmpty()) continue;
    if (!is_existing_map && id + options.min_submap_gap > node.submap) break;
    const LastTried& last = tried[id];
    if (node.id - last.any < options.attempt_spacing || node.id - last.accepted < options.accepted_spacing) continue;
    const double drifted = lengths[static_cast<std::size_t>(id)];
    LoopCandidate candidate;
    candidate.submap = id;
    candidate.half_width = std::min(options.search_base + options.drift_per_metre * drifted, options.max_search);
    candidate.half_angle = std::min(options.search_angle_base + options.yaw_drift_per_metre * drifted, M_PI);
    if (is_existing_map) {
      WidenByEntry(state, candidate);
    } else if ((submap.T_map_submap.translation() - node.T_map_node.translation()).norm() >
               submap.extent + options.max_distance + candidate.half_width) {
      continue;
    }
    candidate.distance = NearestKeyframe(submap, node.T_map_node);
    if (candidate.distance <= options.max_distance + candidate.half_width) candidates.push_back(candidate);
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const LoopCandidate& a, const LoopCandidate& b) { return a.distance < b.distance; });
  if (candidates.size() > static_cast<std::size_t>(options.max_attempts)) {
    candidates.resize(static_cast<std::size_t>(options.max_attempts));
  }
  return candidates;
}

}  // namespace enfilade::slam
