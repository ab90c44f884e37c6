// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "enfilade/v1/prior_map_service.pb.h"
#include "server/app/services.h"
#include "server/rpc/call/call.h"
#include "server/rpc/call/server_stream.h"

namespace enfilade::server {

// The RPCs of PriorMapService but for the import. The proto says what they answer and when they fail.

absl::StatusOr<v1::GetPriorMapResponse> GetPriorMap(const Services& services, const Call& call,
                                                    const v1::GetPriorMapRequest& request);
absl::StatusOr<v1::ListPriorMapsResponse> ListPriorMaps(const Services& services, const Call& call,
                                                        const v1::ListPriorMapsRequest& request);
absl::StatusOr<v1::UpdatePriorMapResponse> UpdatePriorMap(const Services& services, const Call& call,
                                                          const v1::UpdatePriorMapRequest& request);
absl::StatusOr<v1::DeletePriorMapResponse> DeletePriorMap(const Services& services, const Call& call,
                                                          const v1::DeletePriorMapRequest& request);
absl::StatusOr<v1::AlignPriorMapResponse> AlignPriorMap(const Services& services, const Call& call,
                                                        const v1::AlignPriorMapRequest& request);
absl::StatusOr<v1::EditPriorMapResponse> EditPriorMap(const Services& services, const Call& call,
                                                      const v1::EditPriorMapRequest& request);
absl::StatusOr<v1::ActivatePriorMapResponse> ActivatePriorMap(const Services& services, const Call& call,
                                                              const v1::ActivatePriorMapRequest& request);
absl::StatusOr<v1::SuspendPriorMapResponse> SuspendPriorMap(const Services& services, const Call& call,
                                                            const v1::SuspendPriorMapRequest& request);
absl::StatusOr<v1::LocateInPriorMapResponse> LocateInPriorMap(const Services& services, const Call& call,
                                                              const v1::LocateInPriorMapRequest& request);
absl::StatusOr<v1::ListPriorAssociationsResponse> ListPriorAssociations(
    const Services& services, const Call& call, const v1::ListPriorAssociationsRequest& request);
absl::StatusOr<v1::ListPredictedLinkPointsResponse> ListPredictedLinkPoints(
    const Services& services, const Call& call, const v1::ListPredictedLinkPointsRequest& request);
absl::StatusOr<MessageSource<v1::ExportPriorMapResponse>> ExportPriorMap(const Services& services, const Call& call,
                                                                         const v1::ExportPriorMapRequest& request);

}  // namespace enfilade::server
