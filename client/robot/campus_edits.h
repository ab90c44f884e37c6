// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/status.h"
#include "client/sdk/connection.h"
#include "core/base/ids.h"

namespace enfilade::robot {

// What the main menu changes on the server. By display name, id or resource name. NOT_FOUND; FAILED_PRECONDITION where
// something depends on it (its message tells what).
absl::Status DeleteMapOnServer(const client::Connection& connection, const SiteId& site, const std::string& map);
// By id or resource name.
absl::Status DeleteLinkPointOnServer(const client::Connection& connection, const SiteId& site,
                                     const std::string& link_point);

}  // namespace enfilade::robot
