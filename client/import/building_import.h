// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/status.h"
#include "client/import/import_report.h"
#include "client/sdk/connection.h"
#include "core/base/ids.h"
#include "core/prior/formats/building_file.h"

namespace enfilade::client {

// Creates a map for each level of a building, a link point for each lift, and a candidate for each door. The maps'
// names begin with `prefix`. An item that the server refuses is reported, and the others go on; an error of the result
// (see EndsImport) ends the import, and `report` has what was done until then.
absl::Status ImportBuilding(const Connection& connection, const SiteId& site, const prior::Building& building,
                            const std::string& prefix, ImportReport& report);

}  // namespace enfilade::client
