// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "client/sdk/connection.h"
#include "enfilade/v1/link_point.pb.h"

namespace enfilade::client {

// Attaches an image or a point cloud to a link point. `link_point`: sites/{site}/linkPoints/{link_point}; `evidence`
// has its image or its cloud set, whose `content` is filled in here from `bytes`. Within the connection's deadline.
// Errors as LinkPointService.AttachEvidence.
absl::StatusOr<v1::Evidence> AttachEvidence(const Connection& connection, const std::string& link_point,
                                            v1::Evidence evidence, std::string_view bytes);

}  // namespace enfilade::client
