// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/status.h"
#include "client/import/import_report.h"
#include "client/sdk/connection.h"
#include "client/sources/imports/map_manager_database.h"
#include "core/base/ids.h"

namespace enfilade::client {

// Creates the maps, link points and candidates of a map_manager database, with their images and clouds. The ids follow
// from the database's ("map-3", "linkpoint-7", "candidate-2"), so that importing the same database twice creates
// nothing twice. A row that the server refuses is reported, and the others go on; an error of the result (see
// EndsImport) ends the import, and `report` has what was done until then.
absl::Status ImportMapManager(const Connection& connection, const SiteId& site,
                              const sources::MapManagerContent& content, ImportReport& report);

}  // namespace enfilade::client
