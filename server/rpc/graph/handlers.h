// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "enfilade/v1/graph_service.pb.h"
#include "server/app/services.h"
#include "server/rpc/call/call.h"

namespace enfilade::server {

// The unary RPCs of GraphService, one file each. The proto says what they answer and when they fail.

absl::StatusOr<v1::GetGraphResponse> GetGraph(const Services& services, const Call& call,
                                              const v1::GetGraphRequest& request);
absl::StatusOr<v1::ListGraphVersionsResponse> ListGraphVersions(const Services& services, const Call& call,
                                                                const v1::ListGraphVersionsRequest& request);
absl::StatusOr<v1::ListPlacedMapsResponse> ListPlacedMaps(const Services& services, const Call& call,
                                                          const v1::ListPlacedMapsRequest& request);
absl::StatusOr<v1::OptimizeGraphResponse> OptimizeGraph(const Services& services, const Call& call,
                                                        const v1::OptimizeGraphRequest& request);
absl::StatusOr<v1::PreviewGraphResponse> PreviewGraph(const Services& services, const Call& call,
                                                      const v1::PreviewGraphRequest& request);
absl::StatusOr<v1::ChangeGraphResponse> ChangeGraph(const Services& services, const Call& call,
                                                    const v1::ChangeGraphRequest& request);
absl::StatusOr<v1::AlignMapsResponse> AlignMaps(const Services& services, const Call& call,
                                                const v1::AlignMapsRequest& request);
absl::StatusOr<v1::GetGlobalPoseResponse> GetGlobalPose(const Services& services, const Call& call,
                                                        const v1::GetGlobalPoseRequest& request);
absl::StatusOr<v1::TransformPosesResponse> TransformPoses(const Services& services, const Call& call,
                                                          const v1::TransformPosesRequest& request);
absl::StatusOr<v1::FindRoutesResponse> FindRoutes(const Services& services, const Call& call,
                                                  const v1::FindRoutesRequest& request);
absl::StatusOr<v1::SetGeoreferenceResponse> SetGeoreference(const Services& services, const Call& call,
                                                            const v1::SetGeoreferenceRequest& request);
absl::StatusOr<v1::GetGeoreferenceResponse> GetGeoreference(const Services& services, const Call& call,
                                                            const v1::GetGeoreferenceRequest& request);

}  // namespace enfilade::server
