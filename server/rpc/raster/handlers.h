// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "enfilade/v1/raster_service.pb.h"
#include "server/app/services.h"
#include "server/rpc/call/call.h"
#include "server/rpc/call/server_stream.h"

namespace enfilade::server {

// The RPCs of RasterService, one file each. The proto says what they answer and when they fail.

absl::StatusOr<v1::GetRasterManifestResponse> GetRasterManifest(const Services& services, const Call& call,
                                                                const v1::GetRasterManifestRequest& request);
absl::StatusOr<MessageSource<v1::ReadTilesResponse>> ReadTiles(const Services& services, const Call& call,
                                                               const v1::ReadTilesRequest& request);
absl::StatusOr<v1::ListRasterThumbnailsResponse> ListRasterThumbnails(const Services& services, const Call& call,
                                                                      const v1::ListRasterThumbnailsRequest& request);

}  // namespace enfilade::server
