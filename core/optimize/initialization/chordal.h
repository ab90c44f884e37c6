// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "core/optimize/graph_layout.h"
#include "core/optimize/indexed_graph.h"

namespace enfilade::optimize {

// Initial poses without an initial guess, by chordal relaxation (Carlone, Tron, Daniilidis, Dellaert 2015, section
// III-B). Rotations are unit complex numbers z. The relaxation drops the unit length, minimises
//   sum_k kappa_k |z_to - z_m z_from|^2,   kappa_k the marginal information of the measured yaw,
// and normalises the result. The translations are the minimisers for these yaws. Held nodes keep their poses. Empty if
// the equations are singular.
std::optional<std::vector<Pose2>> ChordalPoses(const IndexedGraph& graph, const GraphLayout& layout);

}  // namespace enfilade::optimize
