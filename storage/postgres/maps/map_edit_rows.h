// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "storage/graph/rearrangement_store.h"
#include "storage/maps/map_edit_store.h"
#include "storage/postgres/driver/result.h"
#include "storage/postgres/driver/transaction.h"
#include "storage/postgres/maps/map_key.h"

namespace enfilade::storage::postgres {

#define ENFILADE_DRAFT_COLUMNS                                                                          \
  "site_id, map_id, draft_id, display_name, author, base_edit_version, resolution, origin_x, origin_y," \
  " origin_yaw, head, active_edits, etag, create_time, publish_time, coalesce(edit_version, 0),"        \
  " coalesce(revision, 0), coalesce(message, ''), coalesce((SELECT o.first_version"                     \
  "   FROM enfilade.map_overlays o WHERE o.site_id = map_drafts.site_id AND o.map_id = map_drafts.map_id), 1)"
MapDraft ReadDraft(Row& row);

std::string NameOfDraft(const MapDraftKey& key);

// NOT_FOUND.
absl::StatusOr<MapDraft> ReadDraftOf(Pool& pool, const CallContext& context, const MapDraftKey& key);
// NOT_FOUND if the map has been merged into another one.
absl::StatusOr<MapDraft> InsertDraft(Transaction& transaction, const MapDraft& draft);
// NOT_FOUND.
absl::StatusOr<MapDraft> LockDraft(Transaction& transaction, const MapDraftKey& key);
// As MapEditStore::Append, in a transaction that has locked the draft.
absl::StatusOr<std::int64_t> InsertEdits(Transaction& transaction, const MapDraft& draft,
                                         absl::Span<const NewMapEdit> edits);
// The last one of the queue gives the draft's columns.
void QueuePublished(Transaction& transaction, const MapDraftKey& key, std::int64_t edit_version, std::int64_t revision,
                    const std::string& message);
// What another map has published becomes a publication of `adopted`'s map, in `revision`. Partly queued.
absl::Status AdoptPublication(Transaction& transaction, const AdoptedPublication& adopted, std::int64_t revision);

// As the methods of MapEditStore.
absl::StatusOr<std::vector<StoredMapEdit>> ReadEdits(Pool& pool, const CallContext& context, const MapDraft& draft,
                                                     std::int64_t after_head, std::int64_t after_sequence, int limit);
absl::StatusOr<std::vector<edit::Publication>> ReadPublicationRows(Pool& pool, const CallContext& context,
                                                                   const MapKey& key, std::int64_t after,
                                                                   std::int64_t up_to);
absl::StatusOr<std::vector<LayerWitness>> ReadWitnessRows(Pool& pool, const CallContext& context, const MapKey& key);

}  // namespace enfilade::storage::postgres
