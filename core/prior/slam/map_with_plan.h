// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/prior/fit/fit_plan.h"
#include "core/prior/plan/plan_graph.h"
#include "core/prior/slam/map_log.h"
#include "core/sensor/scan_pairing.h"
#include "core/slam/slam_options.h"

namespace enfilade::prior {

// A log's map and trajectory, corrected by a plan.
struct MapWithPlan {
  MappedLog mapped;  // SLAM's own, bit for bit, unless `corrected`
  bool corrected = false;
  std::string reason;  // why it is not, or what the plan has changed
};

// Maps a log by SLAM, places the plan in the map (FitPlan), and corrects the map by it (docs/plan_slam.md):
//
// 1. The map is cut into pieces (CutIntoPieces), and the graph of these is solved with the plan (SolvePieces), in
//    rounds: the map is drawn again, and the walls that each piece has seen of the plan are looked for from scratch.
// 2. The robot is tracked through the plan (TrackInPlan), and the log mapped again with this path as its odometry. Of
// both
//    maps that one counts which agrees more with the plan and with itself, and in which the plan has the size that the
//    pairs say.
//
// The result is taken only if the map then agrees more with itself (walls that were seen again lie where they did), or
// far more with the plan; if at most a third of the drive had to be bent; if loop closures still agree; and if most
// walls fit (graph::SolveWithPlans). Deterministic. Errors as FitPlan's.
absl::StatusOr<MapWithPlan> MapLogWithPlan(const PlanGraph& plan, const std::vector<sensor::PairedScan>& scans,
                                           const FitOptions& fitting, const slam::SlamOptions& options);

}  // namespace enfilade::prior
