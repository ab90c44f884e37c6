// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "storage/postgres/driver/connection.h"

// A statement that deletes at most `limit` rows of `table` in the site $1 that satisfy `condition`, so that no
// transaction is long. `table`, `condition` and `limit` are SQL in string literals.
#define ENFILADE_DELETE_PORTION(table, condition, limit)                                             \
  ::enfilade::storage::postgres::Statement {                                                         \
    "deleting from " table,                                                                          \
        "DELETE FROM enfilade." table                                                                \
        " WHERE site_id = $1 AND ctid = ANY (ARRAY("                                                 \
        "SELECT ctid FROM enfilade." table " WHERE site_id = $1 AND " condition " LIMIT " limit "))" \
  }
