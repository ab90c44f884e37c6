// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "enfilade/v1/map_service.pb.h"
#include "server/app/services.h"
#include "server/rpc/call/call.h"

namespace enfilade::server {

// The RPCs of MapService that rearrange maps, one file each. The proto says what they answer and when they fail.

absl::StatusOr<v1::MergeMapsResponse> MergeMaps(const Services& services, const Call& call,
                                                const v1::MergeMapsRequest& request);
absl::StatusOr<v1::SplitMapResponse> SplitMap(const Services& services, const Call& call,
                                              const v1::SplitMapRequest& request);
absl::StatusOr<v1::UndoRearrangementResponse> UndoRearrangement(const Services& services, const Call& call,
                                                                const v1::UndoRearrangementRequest& request);
absl::StatusOr<v1::ListRearrangementsResponse> ListRearrangements(const Services& services, const Call& call,
                                                                  const v1::ListRearrangementsRequest& request);

}  // namespace enfilade::server
