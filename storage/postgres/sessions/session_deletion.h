// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "storage/postgres/driver/connection.h"

namespace enfilade::storage::postgres {

// Deletes sessions: one, or all that map into a deleted map. Execute them in this order: locks are taken in the order
// lease, map, session everywhere.

// $1 site, $2 sessions (text[]). Their holders lose the leases.
extern const Statement kRevokeLeases;
// $1 site, $2 sessions (text[]). Keeps the rows, which refuse late records; returns those that were not yet deleted.
extern const Statement kMarkSessionsDeleted;

}  // namespace enfilade::storage::postgres
