// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "core/base/mutex.h"
#include "core/edit/history.h"
#include "core/edit/patches.h"
#include "server/app/edits/draft_check.h"
#include "server/app/edits/draft_view.h"
#include "server/app/edits/edited_revision.h"
#include "server/app/edits/map_ground.h"
#include "storage/graph/link_point_store.h"
#include "storage/graph/rearrangement_store.h"
#include "storage/maps/map_edit_store.h"

namespace enfilade::server {

// An edit as it is drawn: a fill, and what applies to some classes of cells only, becomes a patch.
struct DrawnEdit {
  std::string id;
  std::string author;
  edit::MapEdit edit;  // of a fill without its shape
  struct Fill {
    edit::LatticePoint seed;
    edit::CellBox bounds;
  };
  std::optional<Fill> fill = std::nullopt;
  std::vector<grid::CellClass> only_where = {};  // empty: all
};

struct ChangedTile {
  grid::TileIndex index;
  std::string sha256;  // edit::DigestOf
};

// What a call has changed of a draft, and what has changed since a head that its caller knows.
struct DraftChange {
  std::int64_t head = 0;
  std::vector<storage::StoredMapEdit> edits;  // by head
  std::vector<ChangedTile> tiles;
};

// What a draft shows of a tile's cells: see MapDraftTile in the API.
struct DraftTile {
  grid::TileIndex index;
  std::string cells;
};
struct DraftTiles {
  std::vector<DraftTile> tiles;
  std::int64_t head = 0;
  edit::CellBox box;
  std::vector<grid::TileIndex> known;
};

struct PublishRequest {
  std::int64_t etag = 0;           // 0: any
  std::int64_t expected_head = 0;  // 0: any
  std::string message;
  bool confirm_warnings = false;
};
struct PublishedDraft {
  storage::MapDraft draft;
  ChangeCounts changes;
  std::int64_t merged_publications = 0;
};

struct ConflictResolution {
  edit::CellBox box;
  bool mine = true;
};

struct ContestedPlace {
  edit::Contest contest;
  SessionId session;
  edit::Lattice lattice;
};
struct ContestSettlement {
  edit::CellBox box;
  SessionId session;
  bool keep = true;
};

// People's edits of maps, from their drafts to revisions. Thread-safe.
class MapEdits {
 public:
  // All must outlive it.
  MapEdits(const storage::MapEditStore& edits, const RasterStores& rasters, const storage::LinkPointReader& link_points)
      : edits_(edits), rasters_(rasters), link_points_(link_points), grounds_(rasters, kMaxGroundBytes) {}

  // On the lattice of the map's newest revision. FAILED_PRECONDITION if it has none.
  absl::StatusOr<storage::MapDraft> Create(const storage::CallContext& context, storage::MapDraft draft);

  // INVALID_ARGUMENT naming the edit; FAILED_PRECONDITION if the map's form cannot say its value; as
  // MapEditStore::Append.
  absl::StatusOr<DraftChange> Append(const storage::CallContext& context, const storage::MapDraftKey& key,
                                     absl::Span<const DrawnEdit> edits, std::int64_t known_head);
  // As MapEditStore::SetActive.
  absl::StatusOr<DraftChange> SetActive(const storage::CallContext& context, const storage::MapDraftKey& key,
                                        absl::Span<const std::string> ids, bool active,
                                        const std::optional<std::string>& author, std::int64_t known_head);
  absl::StatusOr<DraftTiles> ReadTiles(const storage::CallContext& context, const storage::MapDraftKey& key,
                                       absl::Span<const grid::TileIndex> tiles);

  absl::StatusOr<DraftCheck> Check(const storage::CallContext& context, const storage::MapDraftKey& key);
  // ABORTED if conflicts are left, or the newest publication is not `edit_version`.
  absl::StatusOr<storage::MapDraft> Rebase(const storage::CallContext& context, const storage::MapDraftKey& key,
                                           std::int64_t edit_version, absl::Span<const ConflictResolution> resolutions,
                                           const std::string& author);
  // ABORTED if there are conflicts; FAILED_PRECONDITION if the check has an error, or a warning that is not confirmed.
  absl::StatusOr<PublishedDraft> Publish(const storage::CallContext& context, const storage::MapDraftKey& key,
                                         const PublishRequest& request);

  // Makes a revision of the map's layers and edits as they are, because layers were restored or areas in which hits are
  // ignored have changed. Does nothing if it would look the same.
  absl::Status Recompose(const storage::CallContext& context, const EditedMap& map) const;

  // Of a change that redirects maps: what was published of their edits becomes publications of the maps that stay,
  // where they lie in them, over those maps' own, unless they are there already.
  absl::Status Adopt(const storage::CallContext& context, const SiteId& site,
                     storage::RearrangementChange& change) const;

  absl::StatusOr<std::vector<ContestedPlace>> ListContested(const storage::CallContext& context, const EditedMap& map);
  // ABORTED if a place is not contested.
  absl::StatusOr<storage::MapDraft> Settle(const storage::CallContext& context, const EditedMap& map,
                                           absl::Span<const ContestSettlement> settlements, const std::string& message,
                                           const std::string& author);

 private:
  static constexpr std::size_t kMaxGroundBytes = std::size_t{256} << 20;
  static constexpr std::size_t kMaxViews = 16;

  // A view that one call uses at a time.
  struct SharedView {
    Mutex mutex;
    DraftView view ABSL_GUARDED_BY(mutex);

    SharedView(const RasterStores& rasters, const storage::MapEditStore& edits, const storage::MapDraftKey& key)
        : view(rasters, edits, key) {}
  };
  std::shared_ptr<SharedView> ViewOf(const storage::MapDraftKey& key);
  // After a change: what it has done, by the store.
  absl::StatusOr<DraftChange> ChangeSince(const storage::CallContext& context, DraftView& view,
                                          std::int64_t known_head);
  absl::StatusOr<DraftCheck> CheckView(const storage::CallContext& context, const DraftView& view);
  absl::StatusOr<std::vector<PlaceInMap>> PlacesIn(const storage::CallContext& context, const EditedMap& map) const;
  // What publishing the edits over all that is published makes of the map's newest revision.
  absl::StatusOr<storage::NewRevision> Compose(const storage::CallContext& context, const EditedMap& map,
                                               const std::vector<edit::KeptEdit>& edits) const;

  // The revision that shows `evidence` with drafts' edits over all that is published, one publication each.
  absl::StatusOr<storage::NewRevision> Lay(const storage::CallContext& context, const EditedMap& map,
                                           const storage::OverlayState& state, grid::MapRaster evidence,
                                           const edit::Lattice& lattice,
                                           absl::Span<const std::vector<edit::KeptEdit>> drafts) const;
  // The published overlay on the lattice.
  absl::StatusOr<edit::Overlay> OverlayOn(const storage::CallContext& context, const EditedMap& map,
                                          const storage::StoredOverlay& published, const edit::Lattice& lattice) const;
  // Of one redirect, without what they become; `change` gets what they were read from.
  absl::StatusOr<std::vector<storage::AdoptedPublication>> PublicationsToAdopt(
      const storage::CallContext& context, const EditedMap& kept, const rearrange::MapRedirect& redirect,
      storage::RearrangementChange& change) const;
  // Numbers what the raster adopts, and lays it over the raster.
  absl::Status AdoptIn(const storage::CallContext& context, const EditedMap& kept,
                       storage::RearrangedRaster& raster) const;

  const storage::MapEditStore& edits_;
  const RasterStores rasters_;
  const storage::LinkPointReader& link_points_;
  MapGrounds grounds_;
  Mutex mutex_;
  std::list<std::pair<std::string, std::shared_ptr<SharedView>>> views_
      ABSL_GUARDED_BY(mutex_);  // by name; recent first
};

}  // namespace enfilade::server
