// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/noise.h"
#include "core/geometry/pose2.h"
#include "core/prior/alignment/control_pairs.h"
#include "core/prior/localization/localizer_options.h"
#include "core/prior/localization/particles.h"
#include "core/prior/localization/plan_field.h"
#include "core/prior/localization/plan_likelihood.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

// Metres per unit of the sheet that particles' scales are relative to: what two pairs or more say; else what the plan
// says; else as if half of its doors were wider than kUsualDoor. INVALID_ARGUMENT: there is nothing to tell it by, the
// pairs cannot be used (FitPairs; one alone only says where its point is), or the plan would be wider than
// kLargestField.
absl::StatusOr<double> NominalScale(const PlanGraph& plan, const std::vector<ControlPair>& pairs);

constexpr double kUsualDoor = 0.9;  // m

// `count` places of a robot by what people have shown: places of the plan in the frame of the robot's own map, where
// it is at `T_map_robot`. Each place is what the pairs say if every point is off by options.click_sigma and the plan is
// stretched along its axes; with one pair, turned anyhow and of any scale within options.scale_spread.
std::vector<PlanParticle> StartAtPairs(const PlanField& field, const std::vector<ControlPair>& pairs,
                                       const Pose2& T_map_robot, std::size_t count,
                                       const PlanLocalizerOptions& options);

// A place near this one: as far off as places that a search has found.
PlanState Spread(PlanState state, Noise noise, const PlanLocalizerOptions& options);

// One search of a whole plan.
struct WideSearch {
  std::size_t count = 0;    // places that are found, at most
  std::uint64_t round = 0;  // numbers the searches: each draws otherwise
  double density = 0;       // places that are tried per square metre
};

// Places anywhere in the plan, drawn by how likely they are: tried with wide walls, then the best with narrower ones
// (an annealed particle filter: J. Deutscher, A. Blake, I. Reid, "Articulated body motion capture by annealed particle
// filtering", 2000). None if `keep_going` ends the search.
std::vector<PlanParticle> StartAnywhere(const PlanField& field, const std::vector<Eigen::Vector2d>& seen,
                                        const WideSearch& search, const PlanLocalizerOptions& options,
                                        const KeepGoing& keep_going = {});

}  // namespace enfilade::prior
