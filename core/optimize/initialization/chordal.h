// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "core/optimize/graph_layout.h"
#include "core/optimize/indexed_graph.h"

namespace enfilade::optimize {

// An initial guess that asks for none (Carlone, Tron, Daniilidis, Dellaert 2015, section III-B, "chordal relaxation"):
// the rotations, as unit complex numbers z, minimise sum kappa |z_to - z_m z_from|^2 without their unit length, and are
// then scaled to it; kappa is the yaw's information with the translation left free. Translations are then the
// minimisers for these yaws. Held nodes keep their poses. Empty if the equations are singular.
std::optional<std::vector<Pose2>> ChordalPoses(const IndexedGraph& graph, const GraphLayout& layout);

}  // namespace enfilade::optimize
