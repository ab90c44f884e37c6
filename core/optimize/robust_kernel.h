// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace enfilade::optimize {

// A kernel rho(s) of the squared Mahalanobis error s = e^T Omega e. It replaces s in the cost, so that a wrong edge
// pulls less. Its derivative rho'(s) scales the edge's information (iteratively reweighted least squares).
struct RobustKernel {
  enum class Type {
    kNone,    // rho = s
    kHuber,   // Huber 1964: s up to w^2, then 2 w sqrt(s) - w^2
    kCauchy,  // w^2 log(1 + s / w^2)
    kDcs,     // dynamic covariance scaling (Agarwal et al. 2013) with Phi = w^2, as a kernel (MacTavish and Barfoot
              // 2015): s up to Phi, then Phi (3 s - Phi) / (s + Phi)
  };
  Type type = Type::kNone;
  double width = 1.0;  // w, in standard deviations; positive
};

struct RobustCost {
  double cost = 0.0;       // rho(s)
  double weight = 1.0;     // d rho / d s, in (0, 1]
  double curvature = 0.0;  // d^2 rho / d s^2, not positive
};

RobustCost Evaluate(const RobustKernel& kernel, double squared_error);

}  // namespace enfilade::optimize
