// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "client/sdk/connection.h"
#include "core/base/ids.h"
#include "enfilade/v1/map.pb.h"
#include "enfilade/v1/map_service.pb.h"

namespace enfilade::client {

// The map of a site that `map` means: its display name, its id or its resource name, in this order. NOT_FOUND.
absl::StatusOr<v1::Map> FindMap(const Connection& connection, const SiteId& site, const std::string& map);

// Likewise; a map that does not exist is created by `request`, whose parent is set here. If another client creates it
// at the same moment, the result is that map.
absl::StatusOr<v1::Map> FindOrCreateMap(const Connection& connection, const SiteId& site, const std::string& map,
                                        v1::CreateMapRequest request);

}  // namespace enfilade::client
