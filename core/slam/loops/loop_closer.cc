// SPDX-License-Identifier: Apache-2.0
#include "core/slam/loops/loop_closer.h"

#include <utility>

#include "core/slam/loops/loop_candidates.h"

namespace enfilade::slam {

LoopClosure ToLoopClosure(const MapperState& state, std::size_t more, std::int64_t submap, std::int64_t node,
                          LoopMatch match) {
  LoopClosure closure;
  closure.id = static_cast<std::int64_t>(state.loop_closures.size() + more);
  closure.submap = submap;
  closure.node = node;
  closure.T_submap_node = match.T_submap_node;
  closure.information = match.information;
  closure.state = match.accepted ? LoopClosureState::kAccepted : LoopClosureState::kRejected;
  closure.score = match.score;
  closure.reason = std::move(match.reason);
  return closure;
}

// Frames: both poses are in the map frame, so the guess is T_submap_node = T_map_submap^-1 T_map_node, and the match
// corrects it. No other frame is involved.
std::vector<LoopClosure> TryLoopClosures(const MapperState& state, const SlamNode& node, const grid::ScanRays& rays,
                                         const SlamOptions& options, SubmapCache& cache) {
  std::vector<LoopClosure> closures;
  for (const LoopCandidate& candidate : SelectLoopCandidates(state, node, options.loop)) {
    const FinishedSubmap& submap = state.finished.at(candidate.submap);
    const Pose2 guess = Between(submap.T_map_submap, node.T_map_node);
    LoopMatch match = MatchLoop(cache.Get(candidate.submap, submap), rays.hits, guess, candidate, options);
    closures.push_back(ToLoopClosure(state, closures.size(), candidate.submap, node.id, std::move(match)));
  }
  return closures;
}

}  // namespace enfilade::slam
