// SPDX-License-Identifier: Apache-2.0
#include "core/graph/chi_squared.h"

#include <Eigen/Core>
#include <unsupported/Eigen/SpecialFunctions>

namespace enfilade::graph {

double ChiSquaredQuantile(double probability, int degrees_of_freedom) {
  const double half = 0.5 * degrees_of_freedom;
  const auto below = [half](double x) { return Eigen::numext::igamma(half, 0.5 * x); };
  double low = 0.0;
  double high = degrees_of_freedom;
  while (below(high) < probability) high *= 2.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (below(middle) < probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace enfilade::graph
