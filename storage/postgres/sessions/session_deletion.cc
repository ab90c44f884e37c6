// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/sessions/session_deletion.h"

namespace enfilade::storage::postgres {

const Statement kRevokeLeases{
    "revoking the sessions' leases",
    "INSERT INTO enfilade.session_leases AS l (site_id, session_id, owner, token, expires_at)"
    " SELECT s.site_id, s.session_id, '', 1, '-infinity' FROM enfilade.sessions s"
    " WHERE s.site_id = $1 AND s.session_id = ANY ($2) ORDER BY s.session_id"
    " ON CONFLICT (site_id, session_id) DO UPDATE SET owner = '', token = l.token + 1, expires_at = '-infinity'"};

const Statement kMarkSessionsDeleted{
    "deleting the sessions",
    "UPDATE enfilade.sessions SET delete_time = now(), robot_id = NULL, map_id = NULL, purged = false"
    " WHERE site_id = $1 AND session_id = ANY ($2) AND delete_time IS NULL RETURNING session_id"};

}  // namespace enfilade::storage::postgres
