#pragma once

#include "absl/status/statusor.h"
#include "enfilade/v1/map_service.pb.h"
#include "server/rpc/server_stream.h"

namespace enfilade::server {

// MapService.ExportMap.
absl::StatusOr<MessageSource<v1::ExportMapResponse>> ExportMap(const Services& services, const CallContext& context,
                                                               const v1::ExportMapRequest& request);

}  // namespace enfilade::server
