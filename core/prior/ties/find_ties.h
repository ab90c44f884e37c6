// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/base/ids.h"
#include "core/geometry/pose2.h"
#include "core/graph/plans/plan_ties.h"
#include "core/prior/alignment/map_evidence.h"
#include "core/prior/alignment/plan_transform.h"
#include "core/prior/correction/correct_plan.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

// A map that may have seen walls of a plan.
struct MapOfPlan {
  MapId id;
  const MapEvidence* evidence = nullptr;
  Pose2 T_plan_map;  // in the frame of the corrected plan
};

// The walls of the plan that each map has seen, as straight lines in the map: those of its walls that lie within 0.5 m
// of a face of the corrected plan, have its direction and look the same way, for 0.8 m or more. A line is fitted to
// them by least squares, without those that are off by more than 0.15 m. The plan itself is as it was placed
// (`T_plan_sheet`), not as it was corrected: the corrections came from the same maps. Its shafts are part of the ties
// if they have a name, with the walls nearest to them.
graph::PlanTies FindTies(const PlanGraph& plan, const PlanTransform& T_plan_sheet, const CorrectedPlan& corrected,
                         const std::vector<MapOfPlan>& maps);

}  // namespace enfilade::prior
