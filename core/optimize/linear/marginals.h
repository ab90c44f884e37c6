// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/optimize/linear/block_cholesky.h"
#include "core/optimize/linear/block_structure.h"

namespace enfilade::optimize {

// The diagonal blocks of (L L^T)^-1 for the columns `wanted` (in elimination order). The recursion of Takahashi, Fagan
// and Chen 1973 computes the inverse where L has blocks, from the last column to the first; here only for those columns
// and their ancestors in the elimination tree.
std::vector<Eigen::Matrix3d> InverseDiagonal(const BlockStructure& structure, const BlockMatrix<3>& L,
                                             const std::vector<int>& wanted);

}  // namespace enfilade::optimize
