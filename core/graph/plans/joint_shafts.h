// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/graph/graph_snapshot.h"
#include "core/graph/joint_graph.h"
#include "core/graph/plans/joint_plans.h"
#include "core/graph/solved_graph.h"

namespace enfilade::graph {

// A shaft of one plan in the joint graph: a node at its middle, which the corners of the plan hold that are near it.
struct ShaftNode {
  std::size_t part = 0;                 // index
  std::size_t shaft = 0;                // ... in PlanTies::shafts
  std::size_t node = 0;                 // ... in the graph
  std::vector<std::size_t> edges = {};  // from corners of the plan, one for each corner of the shaft
};

// What says that two plans of different levels have one shaft at the same place, corner on corner.
struct ShaftTie {
  std::size_t a = 0;  // index of a ShaftNode; that of the lower level
  std::size_t b = 0;
  std::string name = {};
  std::size_t edge = 0;
};

struct JointShafts {
  std::vector<ShaftNode> nodes = {};
  std::vector<ShaftTie> ties = {};
};

// Ties the shafts that parts of different levels have in common (SameShafts), each with each. If m levels have a shaft,
// each of its ties has 2 / m of the information: together they are worth as much as if each level had measured the
// place of the shaft itself. Shafts that no other part has add nothing. Ties are robust; what holds a
// shaft in its plan is not, so that a tie counts or does not.
JointShafts AddShafts(const GraphSnapshot& snapshot, const std::vector<PlanPart>& parts, JointGraph& joint);

// How the shafts of part `index` fit to those of others. `edge_chi2`: of each edge of the graph at its nodes.
std::vector<ShaftUse> UsesOf(const JointGraph& joint, const JointShafts& shafts, const std::vector<PlanPart>& parts,
                             const std::vector<double>& edge_chi2, std::size_t index);

// Why a plan with these shafts is wrong; empty: nothing says so. Of two plans whose shafts disagree nobody can tell
// which one is wrong; of three and more the majority can.
std::string ContradictionOfShafts(const std::vector<ShaftUse>& shafts);

}  // namespace enfilade::graph
