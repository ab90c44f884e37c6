// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "storage/postgres/driver/connection.h"

namespace enfilade::storage::postgres {

// What deleting a session means, for one session and for all that map into a deleted map. Locks are taken in the order
// lease, map, session, as everywhere.

// $1 site, $2 sessions (text[]): whoever holds the lease has lost it.
extern const Statement kRevokeLeases;
// $1 site, $2 sessions (text[]): leaves what late records are refused by; gives the sessions that were not yet deleted.
extern const Statement kMarkSessionsDeleted;

}  // namespace enfilade::storage::postgres
