// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "client/sdk/connection.h"
#include "client/sdk/spool/spool.h"
#include "enfilade/v1/map.pb.h"
#include "enfilade/v1/session.pb.h"

namespace enfilade::client {

// The map of a site that is meant by `map`: its display name, its id or its resource name, in this order. NOT_FOUND.
absl::StatusOr<v1::Map> FindMap(const Connection& connection, const SiteId& site, const std::string& map);

// Makes the server know a spooled session; may be repeated, also after a restart. `create_missing`: a robot or a map
// that the server does not know is created. ALREADY_EXISTS: its id is taken by a session of another robot or map.
absl::StatusOr<v1::Session> EnsureSession(const Connection& connection, const client::SpoolSession& session,
                                          bool create_missing);

// Tells the server that no more records than the spool's last will come. As SessionService.FinishSession.
absl::StatusOr<v1::Session> FinishSession(const Connection& connection, const client::SpoolSession& session);

absl::StatusOr<v1::Session> GetSession(const Connection& connection, const SiteId& site, const SessionId& id);

}  // namespace enfilade::client
