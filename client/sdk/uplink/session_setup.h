// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "client/sdk/connection.h"
#include "client/sdk/spool/spool.h"
#include "enfilade/v1/session.pb.h"

namespace enfilade::client {

// Creates a spooled session on the server, or finds it there; may be repeated, even after a restart. `create_missing`:
// also creates the robot or the map if the server does not have it. ALREADY_EXISTS: the id belongs to a session of
// another robot or map.
absl::StatusOr<v1::Session> EnsureSession(const Connection& connection, const SpoolSession& session,
                                          bool create_missing);

// Finishes the session at the spool's last record. Errors as SessionService.FinishSession.
absl::StatusOr<v1::Session> FinishSession(const Connection& connection, const SpoolSession& session);

absl::StatusOr<v1::Session> GetSession(const Connection& connection, const SiteId& site, const SessionId& id);

}  // namespace enfilade::client
