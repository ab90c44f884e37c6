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

// A log's map, corrected by a plan.
struct MapWithPlan {
  MappedLog mapped;  // SLAM's own, bit for bit, unless `corrected`
  bool corrected = false;
  std::string reason;  // why it is not, or what the plan has changed
};

absl::StatusOr<MapWithPlan> MapLogWithPlan(const PlanGraph& plan, const std::vector<sensor::PairedScan>& scans,
                                           const FitOptions& fitting, const slam::SlamOptions& options);

}  // namespace enfilade::prior
