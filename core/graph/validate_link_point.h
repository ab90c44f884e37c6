// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/status.h"
#include "core/graph/link_point.h"

namespace enfilade::graph {

// Checks that the link point has an id and at least one anchor, no two in the same map, each with a finite pose and a
// valid covariance. INVALID_ARGUMENT names the anchor.
absl::Status ValidateLinkPoint(const LinkPoint& link_point);

}  // namespace enfilade::graph
