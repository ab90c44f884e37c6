// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/import/import_report.h"
#include "client/sdk/api/chunks.h"
#include "client/sdk/connection.h"
#include "core/base/ids.h"
#include "core/prior/formats/building_file.h"

namespace enfilade::client {

// A map of a level's walls, in the level's frame, as the files that ImportMap takes. Empty: there is none.
using LevelDrawing = std::vector<NamedFile>;

// Creates a map for each level of a building, a link point for each lift, and a candidate for each door. The maps'
// names begin with `prefix`; `drawings`, if it is not empty, has the first revision of each level's map. An item that
// the server refuses is reported, and the others go on; an error of the result (see EndsImport) ends the import, and
// `report` has what was done until then.
absl::Status ImportBuilding(const Connection& connection, const SiteId& site, const prior::Building& building,
                            const std::string& prefix, const std::vector<LevelDrawing>& drawings, ImportReport& report);

}  // namespace enfilade::client
