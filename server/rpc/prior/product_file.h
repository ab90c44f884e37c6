// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "proto/convert/names.h"
#include "server/app/services.h"
#include "server/rpc/call/call.h"
#include "storage/maps/prior_map_store.h"

namespace enfilade::server {

constexpr std::string_view kPlanFileName = "plan.geojson";

// The bytes of one of a prior map's files. NOT_FOUND: no such prior map; FAILED_PRECONDITION: it is not aligned, was
// before there were such files, or was corrected since.
absl::StatusOr<std::string> ReadProductFile(const Services& services, const Call& call,
                                            const convert::PriorMapName& name, storage::PriorMapProduct product,
                                            std::string_view file_name);

}  // namespace enfilade::server
