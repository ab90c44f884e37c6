// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace enfilade::graph {

// The quantile of the chi-squared distribution for `probability` in (0, 1), by bisection of the regularised incomplete
// gamma function P(k / 2, x / 2) (Abramowitz and Stegun 1964, 26.4.19).
double ChiSquaredQuantile(double probability, int degrees_of_freedom);

}  // namespace enfilade::graph
