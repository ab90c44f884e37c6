// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/status.h"
#include "client/sdk/connection.h"
#include "core/base/ids.h"

namespace enfilade::robot {

// The main menu's edits of the server's data.

// Deletes a map, given by display name, id or resource name. NOT_FOUND; FAILED_PRECONDITION if something depends on it
// (the message says what).
absl::Status DeleteMapOnServer(const client::Connection& connection, const SiteId& site, const std::string& map);
// The same for a link point, given by id or resource name.
absl::Status DeleteLinkPointOnServer(const client::Connection& connection, const SiteId& site,
                                     const std::string& link_point);

}  // namespace enfilade::robot
