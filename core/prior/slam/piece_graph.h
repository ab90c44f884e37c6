// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"
#include "core/graph/plans/plan_ties.h"
#include "core/graph/solved_graph.h"
#include "core/prior/slam/map_pieces.h"

namespace enfilade::prior {

struct SolvedPieces {
  std::vector<Pose2> T_map_piece;  // of each piece
  graph::PlanUse use;
};

// Solves the graph of pieces, with the plan as a part of it (graph::SolveWithPlans): pieces are what maps are on a
// site, and links what link points are. The first piece is held where it is.
absl::StatusOr<SolvedPieces> SolvePieces(const CutMap& cut, const graph::PlanTies& ties);

// Squared disagreement of a link with the poses, by its covariance: chi-squared with 3 degrees of freedom.
double Chi2Of(const PieceLink& link, const std::vector<Pose2>& T_map_pieces);

}  // namespace enfilade::prior
