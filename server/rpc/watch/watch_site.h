// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "enfilade/v1/watch_service.pb.h"
#include "server/app/services.h"
#include "server/rpc/call/watch_stream.h"

namespace enfilade::server {

// WatchService.WatchSite.
absl::StatusOr<Watch<v1::WatchSiteResponse>> WatchSite(const Services& services, const Call& call,
                                                       const v1::WatchSiteRequest& request);

}  // namespace enfilade::server
