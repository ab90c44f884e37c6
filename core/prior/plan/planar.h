// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

// The same plan as a planar graph: corners nearer to each other than `weld` (units of the plan) are one, walls that end
// nearer than that to another wall join it, walls that cross are cut at the crossing, and walls between the same
// corners are one. Corners without walls are dropped. Doors, rooms and shafts stay as they are. A plan that would get
// more than kMostWalls walls is given back half done, with more than that.
PlanGraph Planarise(const PlanGraph& plan, double weld);

// Ends of walls nearer to each other than this (units of the plan) are meant to meet: 0.05 m, at most a hundredth of
// the plan's diagonal; 1/2000 of that if the scale is unknown.
double JoinDistance(const PlanGraph& plan);

// Whether so many walls lie side by side, or so many corners within `weld`, that Planarise would take minutes. No
// drawing of a building is such.
bool IsCrowded(const PlanGraph& plan, double weld);

// Whether no two walls cross or overlap; touching at a corner of both is allowed.
bool IsPlanar(const PlanGraph& plan);

// The faces of the planar graph of walls and doors, in the order of their area, the largest first. What surrounds the
// plan is no room, nor is a face narrower than `narrowest` (twice its area by its circumference).
std::vector<PlanRoom> FindRooms(const PlanGraph& plan, double narrowest);

// For FindRooms: what is narrower lies within a wall.
double NarrowestRoom(const PlanGraph& plan);

}  // namespace enfilade::prior
