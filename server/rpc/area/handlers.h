// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "enfilade/v1/map_area_service.pb.h"
#include "server/app/services.h"
#include "server/rpc/call/call.h"
#include "server/rpc/call/server_stream.h"

namespace enfilade::server {

// The RPCs of MapAreaService. The proto says what they answer and when they fail.

absl::StatusOr<v1::CreateMapAreaResponse> CreateMapArea(const Services& services, const Call& call,
                                                        const v1::CreateMapAreaRequest& request);
absl::StatusOr<v1::GetMapAreaResponse> GetMapArea(const Services& services, const Call& call,
                                                  const v1::GetMapAreaRequest& request);
absl::StatusOr<v1::ListMapAreasResponse> ListMapAreas(const Services& services, const Call& call,
                                                      const v1::ListMapAreasRequest& request);
absl::StatusOr<v1::UpdateMapAreaResponse> UpdateMapArea(const Services& services, const Call& call,
                                                        const v1::UpdateMapAreaRequest& request);
absl::StatusOr<v1::DeleteMapAreaResponse> DeleteMapArea(const Services& services, const Call& call,
                                                        const v1::DeleteMapAreaRequest& request);
absl::StatusOr<MessageSource<v1::ExportMapAreasResponse>> ExportMapAreas(const Services& services, const Call& call,
                                                                         const v1::ExportMapAreasRequest& request);

}  // namespace enfilade::server
