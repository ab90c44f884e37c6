// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/edit/history.h"
#include "core/edit/map_edit.h"
#include "storage/call_context.h"
#include "storage/maps/revision_store.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

struct MapDraftKey {
  SiteId site;
  MapId map;
  MapDraftId draft;
};

struct MapDraft {
  MapDraftKey key;
  std::string display_name;
  std::string author;
  std::int64_t base_edit_version = 0;  // the map's edits that it lies over
  edit::Lattice lattice;
  // Set by the store.
  std::int64_t head = 0;  // grows with every change of its edits
  std::int64_t active_edits = 0;
  std::int64_t first_version = 1;  // of its map: StoredOverlay::first_version
  std::int64_t etag = 0;
  TimeNs create_time = 0;
  // Of a published one.
  struct Published {
    TimeNs time = 0;
    std::int64_t edit_version = 0;
    std::int64_t revision = 0;
    std::string message;
  };
  std::optional<Published> published;
};

// An edit of a draft.
struct StoredMapEdit {
  edit::KeptEdit kept;    // on the draft's lattice
  std::int64_t head = 0;  // when it last changed
  TimeNs create_time = 0;
};

// An edit that is appended.
struct NewMapEdit {
  std::string id;
  std::string author;
  edit::MapEdit edit;
};

struct NewPublication {
  std::int64_t etag = 0;           // of the draft; 0: any
  std::int64_t expected_head = 0;  // 0: any
  std::string message;
  NewRevision revision;  // with `edits` and `layers_version`
};

// What lies over a map's newest revision.
struct OverlayState {
  std::int64_t layers_version = 0;       // LayersBeside::version
  std::optional<StoredOverlay> overlay;  // unset: nothing was ever published
  std::optional<StoredRaster> evidence;  // the newest revision without edits; unset: it is the revision itself
};

// What a session's layer has seen, with how many publications there were before.
struct LayerWitness {
  SessionId session;
  StoredRaster raster;
  std::int64_t edit_version = 0;
};

// Drafts of maps' edits, and what was published of them. Thread-safe; errors common to all stores: see SiteStore.
class MapEditStore {
 public:
  explicit MapEditStore(postgres::Pool& pool) : pool_(pool) {}

  // NOT_FOUND if the map does not exist; ALREADY_EXISTS.
  absl::StatusOr<MapDraft> Create(const CallContext& context, const MapDraft& draft) const;
  // NOT_FOUND; it says so if the map was merged into another one, and the draft with it.
  absl::StatusOr<MapDraft> Get(const CallContext& context, const MapDraftKey& key) const;
  // The newest first, from the one after `after` (empty: from the first). NOT_FOUND if the map does not exist.
  absl::StatusOr<std::vector<MapDraft>> List(const CallContext& context, const SiteId& site, const MapId& map,
                                             std::optional<bool> published, const MapDraftId& after, int limit) const;
  // NOT_FOUND; ABORTED (etag); FAILED_PRECONDITION if it is published.
  absl::Status Delete(const CallContext& context, const MapDraftKey& key, std::int64_t etag) const;

  // Appends those that the draft does not have; all or none. Returns its new head. NOT_FOUND; FAILED_PRECONDITION if it
  // is published; RESOURCE_EXHAUSTED at kMaxEdits.
  absl::StatusOr<std::int64_t> Append(const CallContext& context, const MapDraftKey& key,
                                      absl::Span<const NewMapEdit> edits) const;
  // Switches edits on or off. `author`: unset: of anybody; otherwise FAILED_PRECONDITION naming an edit of another.
  // NOT_FOUND naming an edit that is not there.
  absl::StatusOr<std::int64_t> SetActive(const CallContext& context, const MapDraftKey& key,
                                         absl::Span<const std::string> ids, bool active,
                                         const std::optional<std::string>& author) const;
  // By head and sequence, those after the given ones.
  absl::StatusOr<std::vector<StoredMapEdit>> ListEdits(const CallContext& context, const MapDraft& draft,
                                                       std::int64_t after_head, std::int64_t after_sequence,
                                                       int limit) const;
  // Puts the draft over a newer publication, with edits that settle conflicts. ABORTED if its base is not `from` any
  // more.
  absl::StatusOr<MapDraft> Rebase(const CallContext& context, const MapDraftKey& key, std::int64_t from,
                                  std::int64_t to, absl::Span<const NewMapEdit> edits) const;

  absl::StatusOr<OverlayState> ReadOverlay(const CallContext& context, const SiteId& site, const MapId& map) const;
  // The layers of sessions that began after a publication.
  absl::StatusOr<std::vector<LayerWitness>> ReadWitnesses(const CallContext& context, const SiteId& site,
                                                          const MapId& map) const;

  // In one transaction: the draft is published, its revision is the map's newest one, and whoever composes a revision
  // meanwhile does it again. ABORTED with AreLayersChanged if the map has changed since `revision` was made; ABORTED on
  // another etag or head; FAILED_PRECONDITION if it is published.
  absl::StatusOr<MapDraft> Publish(const CallContext& context, const MapDraftKey& key,
                                   const NewPublication& publication) const;
  // The same of edits that are published at once, without having been a draft before.
  absl::StatusOr<MapDraft> PublishAtOnce(const CallContext& context, const MapDraft& draft,
                                         absl::Span<const NewMapEdit> edits, const NewPublication& publication) const;
  // A revision that shows the same layers and edits in another way. ABORTED with AreLayersChanged as Publish.
  absl::Status StoreRecomposed(const CallContext& context, const SiteId& site, const MapId& map,
                               const NewRevision& revision) const;

  // Of a draft.
  static constexpr std::int64_t kMaxEdits = 100'000;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
