// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/prior/plan/plan_graph.h"

namespace enfilade::testing {

// Shares of `expected` that were found, and of `found` that is true.
struct PlanScore {
  double recall = 0;
  double precision = 0;
  double median_error = 0;  // of what was found, units of the plan
};

struct PlanTolerance {
  double step = 0.25;                          // between samples along walls
  double distance = 0.2;                       // across; of corners `corner_distance`
  double angle = 12 * 3.14159265358979 / 180;  // rad
  double corner_distance = 0.3;
  double door_distance = 0.5;  // between the middles
  // Whether a line anywhere within the thickness of a wall is that wall: of plans that draw some walls along a face.
  bool within_thickness = false;
};

// By samples along walls: one counts if a wall of the other plan runs there in the same direction.
PlanScore ScoreWalls(const prior::PlanGraph& found, const prior::PlanGraph& expected, const PlanTolerance& tolerance);

// The middles of the samples along walls of `of` that lie on no wall of `on`.
std::vector<Eigen::Vector2d> SamplesOffWalls(const prior::PlanGraph& of, const prior::PlanGraph& on,
                                             const PlanTolerance& tolerance);

// The share of walls, by their length, beside which another wall runs in the same direction, no farther away than
// `reach` (units of the plan): walls that were read twice.
double ShareOfDoubleWalls(const prior::PlanGraph& plan, double step, double reach);

// Corners where walls of different directions meet, and ends of walls.
PlanScore ScoreCorners(const prior::PlanGraph& found, const prior::PlanGraph& expected, const PlanTolerance& tolerance);

PlanScore ScoreDoors(const prior::PlanGraph& found, const prior::PlanGraph& expected, const PlanTolerance& tolerance);

// The tolerance in units of the plan, from metres.
PlanTolerance InUnits(const PlanTolerance& tolerance, double metres_per_unit);

}  // namespace enfilade::testing
