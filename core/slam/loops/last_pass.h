// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/slam/loops/submap_cache.h"
#include "core/slam/slam_options.h"
#include "core/slam/state/mapper_state.h"

namespace enfilade::slam {

// Two submaps that may show the same place, and that the graph ties to each other only by a long way.
struct UnjoinedPair {
  std::int64_t earlier = 0;
  std::int64_t later = 0;
  double distance = 0.0;  // m, between their nearest keyframes, by the current estimate
  double drifted = 0.0;   // m, DriftLengths from one to the other
};

// Goes through all pairs of finished submaps when there are no more scans. While a robot records, it tries a few
// submaps from every other keyframe or so, each by one scan; where it comes back to a place only shortly before its
// log ends, that may not be enough. Here all that the later submap shows around a keyframe is matched at once.
class LastPass {
 public:
  explicit LastPass(const SlamOptions& options) : options_(options) {}

  // The pair to try next, the nearest first; each is given once. Unset: none is left. An existing map is in no pair.
  std::optional<UnjoinedPair> Next(const MapperState& state);
  // Rows for the attempts, as TryLoopClosures gives them: from up to three keyframes of the later submap, so that the
  // graph can compare them; one row if the first is rejected. Does not change the state.
  std::vector<LoopClosure> Try(const MapperState& state, const UnjoinedPair& pair, SubmapCache& cache) const;
  // The graph has been solved with another closure: pairs are apart by other ways.
  void Forget() { pairs_.reset(); }

 private:
  void FindPairs(const MapperState& state);

  const SlamOptions options_;
  std::set<std::pair<std::int64_t, std::int64_t>> tried_;
  std::optional<std::vector<UnjoinedPair>> pairs_;  // the nearest last
};

}  // namespace enfilade::slam
