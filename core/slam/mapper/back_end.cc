// SPDX-License-Identifier: Apache-2.0
#include "core/slam/mapper/back_end.h"

#include <cstdint>
#include <optional>
#include <utility>

#include "core/slam/loops/last_pass.h"
#include "core/slam/loops/loop_closer.h"
#include "core/slam/loops/reconsider.h"
#include "core/slam/loops/slam_graph.h"
#include "core/slam/mapper/policies.h"

namespace enfilade::slam {

void BackEnd::CloseLoops(const SlamNode& node, const grid::ScanRays& rays, MapperState& state) {
  Add(TryLoopClosures(state, node, rays, options_, cache_), state);
  const auto nodes = static_cast<std::int64_t>(state.nodes.size());
  if (state.unsolved_closures && IsSolveDue(nodes, state.nodes_at_solve, state.urgent_closures, options_.graph)) {
    Solve(state);
    Reconsider(state);
  }
}

void BackEnd::Add(std::vector<LoopClosure> closures, MapperState& state) {
  for (LoopClosure& closure : closures) {
    changes_.MarkLoopClosure(closure.id);
    if (closure.state == LoopClosureState::kAccepted) {
      state.unsolved_closures = true;
      Join(closure, state);
      if (LoopClosureChi2(state, closure) > options_.graph.urgent_chi2) state.urgent_closures = true;
    }
    state.loop_closures[closure.id] = std::move(closure);
  }
}

void BackEnd::Finish(bool join, MapperState& state) {
  Solve(state);
  if (!options_.close_loops) return;
  Reconsider(state);
  if (join) JoinUnjoined(state);
}

void BackEnd::JoinUnjoined(MapperState& state) {
  LastPass pass(options_);
  while (const std::optional<UnjoinedPair> pair = pass.Next(state)) {
    Add(pass.Try(state, *pair, cache_), state);
    if (!state.unsolved_closures) continue;
    Solve(state);
    Reconsider(state);
    pass.Forget();
  }
}

void BackEnd::Solve(MapperState& state) {
  changes_.Mark(SolveSlamGraph(options_.graph, state));
  JoinAll(state);
  state.nodes_at_solve = static_cast<std::int64_t>(state.nodes.size());
  state.unsolved_closures = false;
  state.urgent_closures = false;
  if (state.adrift_since && IsRecognised(state, *state.adrift_since)) state.adrift_since.reset();
}

// Accepts closures that the graph has rejected and that agree with one another, set by set.
void BackEnd::Reconsider(MapperState& state) {
  constexpr int kMostSets = 8;
  for (int set = 0; set < kMostSets; ++set) {
    std::optional<Reconsidered> found = ReconsiderClosures(state, options_, cache_);
    if (!found) return;
    for (const std::int64_t submap : found->contents) changes_.MarkContent(submap);
    // Those that the graph had moved already keep their marks.
    for (const auto& [id, submap] : found->state.finished) changes_.MarkSubmap(id);
    for (const auto& [id, node] : found->state.nodes) changes_.MarkNode(id);
    changes_.Mark(found->change);
    state = std::move(found->state);
    Solve(state);
  }
}

}  // namespace enfilade::slam
