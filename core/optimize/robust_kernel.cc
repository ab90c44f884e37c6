// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/robust_kernel.h"

#include <cmath>

namespace enfilade::optimize {

RobustCost Evaluate(const RobustKernel& kernel, double squared_error) {
  const double s = squared_error;
  const double w2 = kernel.width * kernel.width;
  switch (kernel.type) {
    case RobustKernel::Type::kNone:
      break;
    case RobustKernel::Type::kHuber:
      if (s > w2) {
        const double weight = kernel.width / std::sqrt(s);
        return {2.0 * kernel.width * std::sqrt(s) - w2, weight, -0.5 * weight / s};
      }
      break;
    case RobustKernel::Type::kCauchy:
      return {w2 * std::log1p(s / w2), w2 / (w2 + s), -w2 / ((w2 + s) * (w2 + s))};
    case RobustKernel::Type::kDcs:
      if (s > w2) {
        const double scale = 2.0 * w2 / (s + w2);
        return {w2 * (3.0 * s - w2) / (s + w2), scale * scale, -2.0 * scale * scale / (s + w2)};
      }
      break;
  }
  return {s, 1.0, 0.0};
}

}  // namespace enfilade::optimize
