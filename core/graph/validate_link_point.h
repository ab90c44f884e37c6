#pragma once

#include "absl/status/status.h"
#include "core/graph/link_point.h"

namespace enfilade {

// INVALID_ARGUMENT saying what is wrong unless the matrix is finite, symmetric and positive semi-definite, each to one
// part in 10^9 of its largest element.
absl::Status ValidateCovariance(const Eigen::Matrix3d& covariance);

// INVALID_ARGUMENT, naming the anchor, unless the link point has an id and at least one anchor, no two in the same map,
// each with a finite pose and a valid covariance.
absl::Status ValidateLinkPoint(const LinkPoint& link_point);

}  // namespace enfilade
