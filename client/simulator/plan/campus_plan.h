// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "client/simulator/campus/campus.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::simulator {

// The plan of one level as it is built: walls along their centre lines, cut at doors, areas as rooms, lifts as shafts.
// Its unit is the metre, and a point (x, y) of the campus frame is (x, -y) in the sheet. Furniture is not drawn.
prior::PlanGraph PlanOf(const Campus& campus, const std::string& level);

Eigen::Vector2d ToCampus(const Eigen::Vector2d& point_sheet);

}  // namespace enfilade::simulator
