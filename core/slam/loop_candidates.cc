#include "core/slam/loop_candidates.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

namespace enfilade {
namespace {

double NearestKeyframe(const FinishedSubmap& submap, const Pose2& T_map_node) {
  const Eigen::Vector2d p = (Inverse(submap.T_map_submap) * T_map_node).translation();
  double nearest = std::numeric_limits<double>::max();
  for (const SubmapNode& node : submap.nodes) {
    nearest = std::min(nearest, (node.T_submap_node.translation() - p).squaredNorm());
  }
  return std::sqrt(nearest);
}

// The last nodes of the current submap from which `submap` was tried: in general, and with success.
struct LastTried {
  std::int64_t any = std::numeric_limits<std::int64_t>::min() / 2;
  std::int64_t accepted = std::numeric_limits<std::int64_t>::min() / 2;
};

}  // namespace

std::map<std::int64_t, double> DriftLengths(const MapperState& state, std::int64_t from) {
  std::map<std::int64_t, std::vector<std::pair<std::int64_t, double>>> ways;
  for (const auto& [id, submap] : state.finished) {
    ways[id].emplace_back(id + 1, submap.length);
    ways[id + 1].emplace_back(id, submap.length);
  }
  for (const auto& [id, closure] : state.closures) {
    if (closure.state != ClosureState::kAccepted) continue;
    const std::int64_t other = state.nodes.at(closure.node).submap;
    ways[closure.submap].emplace_back(other, 0.0);
    ways[other].emplace_back(closure.submap, 0.0);
  }
  std::map<std::int64_t, double> lengths;
  using Entry = std::pair<double, std::int64_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  open.emplace(0.0, from);
  while (!open.empty()) {
    const auto [length, submap] = open.top();
    open.pop();
    if (!lengths.emplace(submap, length).second) continue;
    for (const auto& [next, way] : ways[submap]) open.emplace(length + way, next);
  }
  return lengths;
}

std::vector<LoopCandidate> SelectLoopCandidates(const MapperState& state, const SlamNode& node,
                                                const LoopOptions& options) {
  std::vector<LoopCandidate> candidates;
  if (state.finished.empty()) return candidates;
  std::map<std::int64_t, LastTried> tried;
  for (auto it = state.closures.rbegin(); it != state.closures.rend(); ++it) {
    const SlamClosure& closure = it->second;
    if (node.id - closure.node > options.accepted_spacing) break;
    LastTried& last = tried[closure.submap];
    last.any = std::max(last.any, closure.node);
    if (closure.state == ClosureState::kAccepted) last.accepted = std::max(last.accepted, closure.node);
  }
  const std::map<std::int64_t, double> lengths = DriftLengths(state, node.submap);
  for (const auto& [id, submap] : state.finished) {
    if (id + options.min_submap_gap > node.submap) break;
    const LastTried& last = tried[id];
    if (node.id - last.any < options.attempt_spacing || node.id - last.accepted < options.accepted_spacing) continue;
    const auto length = lengths.find(id);
    const double drifted = length == lengths.end() ? std::numeric_limits<double>::max() : length->second;
    LoopCandidate candidate;
    candidate.submap = id;
    candidate.half_width = std::min(options.search_base + options.drift_per_metre * drifted, options.max_search);
    candidate.half_angle = std::min(options.search_angle_base + options.yaw_drift_per_metre * drifted, M_PI);
    if ((submap.T_map_submap.translation() - node.T_map_node.translation()).norm() >
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

}  // namespace enfilade
