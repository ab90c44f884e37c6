// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/rearrange/rearrangement.h"
#include "storage/call_context.h"
#include "storage/graph/site_lease_store.h"
#include "storage/maps/map_edit_store.h"
#include "storage/maps/revision_store.h"

namespace enfilade::storage {

// A layer that enters a map, rendered in that map's frame. Its tiles' blobs are stored.
struct EnteringLayer {
  std::optional<SessionId> session;  // unset: what was imported into a map that is redirected here
  StoredRaster raster;
};

// What was published of a map that is redirected becomes a publication of the map that stays, as old as it was.
struct AdoptedPublication {
  MapId from;
  std::int64_t from_version = 0;  // its edit_version there
  MapDraft draft;                 // of the map that stays
  std::vector<NewMapEdit> edits;
  std::int64_t edit_version = 0;
  std::string message;
};

// The raster of a map whose layers change and that stays: the layers of sessions that leave it are dropped, `entering`
// ones are put on top of the rest, and `revision` overlays the result.
struct RearrangedRaster {
  MapId map;
  std::int64_t layers_version = 0;               // of the layers that it was composed from; 0: the map had none
  std::vector<EnteringLayer> entering;           // from the bottom to the top
  std::optional<NewRevision> revision;           // unset: no layer is left, and the map has no revision so far
  std::vector<AdoptedPublication> adopted = {};  // that `revision` shows
};

// The layers and edits of a map that is redirected, as the rasters were made by them.
struct SeenLayers {
  MapId map;
  std::int64_t version = 0;  // LayersBeside::version
};

// A rearrangement with what it makes of rasters.
struct RearrangementChange {
  rearrange::RearrangementId id;
  rearrange::Rearrangement rearrangement;
  std::int64_t graph_version = 0;  // that it was decided by
  std::vector<RearrangedRaster> rasters;
  std::vector<SeenLayers> seen = {};  // ABORTED if they are others by now
  bool by_people = false;             // pins the maps that it leaves behind (Map::pinned)
};

// A rearrangement that was applied.
struct StoredRearrangement {
  SiteId site;
  rearrange::RearrangementId id;
  std::string reason;
  std::string actor;                // CallContext::actor of the call that applied it
  std::int64_t version_before = 0;  // of the graph
  std::int64_t version_after = 0;
  std::int64_t version_undone = 0;  // 0: not undone
  TimeNs create_time = 0;
  std::optional<TimeNs> undo_time;
  bool undo_expired = false;  // what undoing needs is deleted (Maintenance): it can no longer be undone
  // What it did.
  std::vector<MapId> new_maps;
  std::vector<rearrange::SessionCut> cuts;
  std::vector<rearrange::SessionMove> moves;
  std::vector<rearrange::MapRedirect> redirects;
  std::vector<LinkPointId> changed_link_points;  // new or changed
  std::vector<LinkPointId> removed_link_points;
};

// Rearrangements of a site's maps, and their undoing. Each is one transaction that raises the graph's version once:
// readers see all of it or nothing, and never wait. Thread-safe; errors common to all stores: see SiteStore.
class RearrangementStore {
 public:
  virtual ~RearrangementStore() = default;

  // Moves sessions with everything in their maps' frames (submaps, keyframes, tracks, entries, verdicts, robots' poses,
  // evidence), changes link points, layers and revisions, takes edits along, and redirects the maps that are left
  // empty. ABORTED if the lease is lost, the graph is no longer at change.graph_version, or layers have changed
  // (AreLayersChanged): decide again. FAILED_PRECONDITION naming a session that is still recorded or mapped, a session
  // that is left in a map that is redirected, or a session to be cut that has no record there; NOT_FOUND;
  // ALREADY_EXISTS if an id is taken.
  virtual absl::StatusOr<StoredRearrangement> Apply(const CallContext& context, const SiteLease& lease,
                                                    const RearrangementChange& change) const = 0;
  // Restores exactly what was before: poses, link points, evidence, layers; rasters as new revisions with the old
  // content. Pins the maps that it leaves behind. ABORTED if the lease is lost; NOT_FOUND; FAILED_PRECONDITION if it
  // has been undone already, if it is too old (StoredRearrangement::undo_expired), or naming what has been changed
  // since: then nothing is undone.
  virtual absl::StatusOr<StoredRearrangement> Undo(const CallContext& context, const SiteLease& lease,
                                                   const rearrange::RearrangementId& id) const = 0;
  // Where the id of a map leads to, through any number of redirects. A map that is not redirected, or does not exist,
  // leads to itself.
  virtual absl::StatusOr<rearrange::MapRedirect> Resolve(const CallContext& context, const SiteId& site,
                                                         const MapId& map) const = 0;
  // NOT_FOUND.
  virtual absl::StatusOr<StoredRearrangement> Get(const CallContext& context, const SiteId& site,
                                                  const rearrange::RearrangementId& id) const = 0;
  // Those whose version_after is below `before` (0: all), newest first.
  virtual absl::StatusOr<std::vector<StoredRearrangement>> List(const CallContext& context, const SiteId& site,
                                                                std::int64_t before, int limit) const = 0;
};

}  // namespace enfilade::storage
