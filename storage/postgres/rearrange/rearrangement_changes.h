// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "storage/graph/rearrangement_store.h"
#include "storage/postgres/driver/transaction.h"

namespace enfilade::storage::postgres {

// The steps of applying a rearrangement whose parts are stored, within a transaction that has locked the site's graph,
// raised it to `version` and called QueueRearranging. What they change follows from the parts.

// For the rest of the transaction, triggers know that it rearranges: maps that are added raise no version.
void QueueRearranging(Transaction& transaction, const rearrange::RearrangementId& id);

// Locks maps and sessions, and checks that they may change. Errors as RearrangementStore::Apply.
absl::Status LockAndCheck(Transaction& transaction, const SiteId& site, const RearrangementChange& change);
// Keeps everything that will change as it is, and the blobs that undoing needs. Queued only.
void QueueImagesBefore(Transaction& transaction, const SiteId& site, const rearrange::RearrangementId& id);
// Adds the new maps, in the place in the world that the sessions that move there give them.
absl::Status AddMaps(Transaction& transaction, const SiteId& site, const RearrangementChange& change,
                     std::int64_t version);
// Moves areas with the keyframes that are near to them, which still have their old poses, and keeps the images of the
// areas that it moves. Queued only.
void QueueAreaMoves(Transaction& transaction, const SiteId& site, const rearrange::RearrangementId& id);
// Moves sessions and what else is in the frames of their maps. Queued only.
void QueueMoves(Transaction& transaction, const SiteId& site, const rearrange::RearrangementId& id);
// Moves the open drafts of maps that are redirected into the maps that stay, where they lie in them, over the edits
// that they were drawn over. Queued only.
void QueueDraftMoves(Transaction& transaction, const SiteId& site, const RearrangementChange& change);
absl::Status ChangeLinkPoints(Transaction& transaction, const SiteId& site, const RearrangementChange& change,
                              std::int64_t version);
// Layers and revisions. ABORTED if layers have changed.
absl::Status ChangeRasters(Transaction& transaction, const SiteId& site, const RearrangementChange& change);
// Makes the maps that are left empty redirects. Queued only.
void QueueRedirects(Transaction& transaction, const SiteId& site, const rearrange::RearrangementId& id);
// Pins the maps that it leaves behind. Queued only.
void QueuePins(Transaction& transaction, const SiteId& site, const rearrange::RearrangementId& id);
// Keeps everything that has changed as it is now. Queued only.
void QueueImagesAfter(Transaction& transaction, const SiteId& site, const rearrange::RearrangementId& id);

}  // namespace enfilade::storage::postgres
