// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "absl/status/statusor.h"
#include "core/edit/map_edit.h"
#include "storage/maps/map_edit_store.h"
#include "storage/maps/revision_store.h"
#include "storage/postgres/driver/result.h"
#include "storage/postgres/driver/transaction.h"
#include "storage/postgres/maps/map_key.h"

namespace enfilade::storage::postgres {

// The next four columns: resolution, origin_x, origin_y, origin_yaw.
edit::Lattice ReadLattice(Row& row);

// The edits that lie over a revision that is being stored, and what is below them. Queued only.
void QueueRevisionEdits(Transaction& transaction, const MapKey& key, const NewRevision& revision);

// Without `layers_version`.
absl::StatusOr<OverlayState> ReadOverlayRows(Pool& pool, const CallContext& context, const MapKey& key);

}  // namespace enfilade::storage::postgres
