// SPDX-License-Identifier: Apache-2.0
#include "core/slam/loops/loop_closer.h"

#include "core/slam/loops/loop_candidates.h"
#include "core/slam/loops/loop_matching.h"

namespace enfilade::slam {

// Frames: both poses are in the map frame, so the guess is T_submap_node = T_map_submap^-1 T_map_node, and the match
// corrects it. No other frame is involved.
std::vector<LoopClosure> TryLoopClosures(const MapperState& state, const SlamNode& node, const grid::ScanRays& rays,
                                         const SlamOptions& options, SubmapCache& cache) {
  std::vector<LoopClosure> closures;
  for (const LoopCandidate& candidate : SelectLoopCandidates(state, node, options.loop)) {
    const FinishedSubmap& submap = state.finished.at(candidate.submap);
    const Pose2 guess = Between(submap.T_map_submap, node.T_map_node);
    LoopMatch match = MatchLoop(cache.Get(candidate.submap, submap), rays.hits, guess, candidate, options);
    LoopClosure closure;
    closure.id = static_cast<std::int64_t>(state.loop_closures.size() + closures.size());
    closure.submap = candidate.submap;
    closure.node = node.id;
    closure.T_submap_node = match.T_submap_node;
    closure.information = match.information;
    closure.state = match.accepted ? LoopClosureState::kAccepted : LoopClosureState::kRejected;
    closure.score = match.score;
    closure.reason = std::move(match.reason);
    closures.push_back(std::move(closure));
  }
  return closures;
}

}  // namespace enfilade::slam
