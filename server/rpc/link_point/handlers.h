// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "enfilade/v1/link_point_service.pb.h"
#include "server/app/services.h"
#include "server/rpc/call/call.h"

namespace enfilade::server {

// The unary RPCs of LinkPointService, one file each. The proto says what they answer and when they fail.

absl::StatusOr<v1::CreateLinkPointResponse> CreateLinkPoint(const Services& services, const Call& call,
                                                            const v1::CreateLinkPointRequest& request);
absl::StatusOr<v1::AddLinkPointAnchorResponse> AddLinkPointAnchor(const Services& services, const Call& call,
                                                                  const v1::AddLinkPointAnchorRequest& request);
absl::StatusOr<v1::GetLinkPointResponse> GetLinkPoint(const Services& services, const Call& call,
                                                      const v1::GetLinkPointRequest& request);
absl::StatusOr<v1::ListLinkPointsResponse> ListLinkPoints(const Services& services, const Call& call,
                                                          const v1::ListLinkPointsRequest& request);
absl::StatusOr<v1::UpdateLinkPointResponse> UpdateLinkPoint(const Services& services, const Call& call,
                                                            const v1::UpdateLinkPointRequest& request);
absl::StatusOr<v1::DeleteLinkPointResponse> DeleteLinkPoint(const Services& services, const Call& call,
                                                            const v1::DeleteLinkPointRequest& request);
absl::StatusOr<v1::SuspendLinkPointResponse> SuspendLinkPoint(const Services& services, const Call& call,
                                                              const v1::SuspendLinkPointRequest& request);
absl::StatusOr<v1::ResumeLinkPointResponse> ResumeLinkPoint(const Services& services, const Call& call,
                                                            const v1::ResumeLinkPointRequest& request);
// Answer into `response`, which lies in an arena (ArenaMessages). TryFindLinkPoints answers searches of the
// surroundings, if the graph is in memory.
std::optional<absl::Status> TryFindLinkPoints(const Services& services, const v1::FindLinkPointsRequest& request,
                                              v1::FindLinkPointsResponse& response);
absl::Status FindLinkPoints(const Services& services, const Call& call, const v1::FindLinkPointsRequest& request,
                            v1::FindLinkPointsResponse& response);

}  // namespace enfilade::server
