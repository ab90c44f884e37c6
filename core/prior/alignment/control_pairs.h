// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/prior/alignment/plan_transform.h"

namespace enfilade::prior {

// The same point, shown by a person on the sheet and in the map.
struct ControlPair {
  Eigen::Vector2d point_sheet = Eigen::Vector2d::Zero();
  Eigen::Vector2d point_map = Eigen::Vector2d::Zero();  // m
};

constexpr double kClickSigma = 0.3;  // m, in each axis

struct PairFit {
  PlanTransform T_map_sheet;
  TransformModel model = TransformModel::kSimilarity;
  std::vector<double> residuals;  // m, of each pair
  // The pair that contradicts the others (five and more tell which; of fewer none does): it is left out of the fit.
  std::optional<std::size_t> wrong;
  // Other places that the pairs fit about as well: turned over, and with another scale along the sheet's y than along
  // its x. Two pairs leave many; well spread ones none.
  std::vector<PlanTransform> others;
};

// Least squares: a similarity, turned over if that fits much better (S. Umeyama, "Least-squares estimation of
// transformation parameters between two point patterns", 1991), from four well spread pairs on with a scale for each
// axis of the sheet, if `widest` allows it. INVALID_ARGUMENT: fewer than two pairs or more than 1000, points that are
// not finite, two pairs at one place, pairs nearer together than 2 m or a twentieth of `sheet_size` (the diagonal of
// the plan's walls, in its units), pairs that make the plan larger than kLargestPlan.
absl::StatusOr<PairFit> FitPairs(const std::vector<ControlPair>& pairs, double sheet_size,
                                 TransformModel widest = TransformModel::kAffine);

}  // namespace enfilade::prior
