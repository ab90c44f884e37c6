// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "core/slam/loops/slam_graph.h"
#include "core/slam/loops/submap_cache.h"
#include "core/slam/slam_options.h"
#include "core/slam/state/mapper_state.h"

namespace enfilade::slam {

// The largest set found of rejected loop closures that agree with one another: each pair closes a small loop through
// the graph between them, within the drift of its length (Mangelson et al. 2018, "Pairwise Consistent Measurement Set
// Maximization"; greedily, from each closure in turn). Empty if there are fewer than `min_agreeing`, from keyframes
// less than `min_agreeing_length` apart in all.
std::vector<std::int64_t> FindAgreeingClosures(const MapperState& state, const LoopOptions& options);

// A state in which closures that were rejected hold, because the ties between submaps that contradict them are weaker.
struct Reconsidered {
  MapperState state;
  std::set<std::int64_t> contents;  // ids of the submaps whose content (the tie to the next) has changed
  GraphChange change;
};

// Rejected closures that agree with one another say more than the ties that they contradict: a submap's tie to the next
// is one match, and its stated covariance knows nothing of a wheel that slipped or of a wrong match. Solves the graph
// with these closures and with a robust kernel on the ties; weakens the ties that have to give. Nothing if there are no
// such closures, if accepted ones would be lost, or if the walls of the submaps that they join then contradict each
// other's free space (as in a place that only looks alike).
std::optional<Reconsidered> ReconsiderClosures(const MapperState& state, const SlamOptions& options,
                                               SubmapCache& cache);

}  // namespace enfilade::slam
