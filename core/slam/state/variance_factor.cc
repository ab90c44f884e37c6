// SPDX-License-Identifier: Apache-2.0
#include "core/slam/state/variance_factor.h"

#include <algorithm>

namespace enfilade::slam {
namespace {

constexpr double kMatchesFreedom = 30.0;  // the matches count as much as 14 loop closures
constexpr double kOwnShare = 0.7;         // of a loop closure's freedom: neighbouring closures share the rest
constexpr double kLeast = 0.01;           // scans without noise and of nothing but walls have no residuals

}  // namespace

double VarianceFactor(const ErrorStatistics& statistics) {
  if (statistics.matches == 0) return 1.0;
  const double matches = statistics.match_squares / static_cast<double>(statistics.matches);
  const double freedom = kMatchesFreedom + kOwnShare * static_cast<double>(statistics.redundancy);
  return std::max(kLeast, (kMatchesFreedom * matches + statistics.graph_chi2) / freedom);
}

}  // namespace enfilade::slam
