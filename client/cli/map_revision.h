// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "client/cli/command.h"
#include "client/sdk/connection.h"
#include "enfilade/v1/map.pb.h"
#include "nlohmann/json.hpp"

namespace enfilade::cli {

// The resource name of a revision or alias of `map`: 12 is a revision, stable an alias. Empty: the newest revision;
// FAILED_PRECONDITION if it has none.
absl::StatusOr<std::string> RevisionNameOf(const v1::Map& map, const std::string& revision);

// The same of a text MAP[@REVISION|@ALIAS], where MAP is a map's name, id or resource name. The resource name of a
// revision or an alias stays as it is. NOT_FOUND: no such map.
absl::StatusOr<std::string> FindRevision(const client::Connection& connection, const Globals& globals,
                                         const std::string& text);

// As programs and people read what a revision is.
nlohmann::json RevisionToJson(const v1::MapRevision& revision);
void PrintRevision(const v1::MapRevision& revision);

}  // namespace enfilade::cli
