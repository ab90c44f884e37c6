// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "core/rearrange/rearrangement.h"
#include "core/slam/slam_profiles.h"
#include "server/app/edits/map_edits.h"
#include "server/app/graph/site_graphs.h"
#include "storage/call_context.h"
#include "storage/graph/rearrangement_store.h"
#include "storage/graph/site_lease_store.h"
#include "storage/maps/blob_store.h"
#include "storage/maps/map_store.h"
#include "storage/maps/revision_store.h"
#include "storage/sessions/mapping_store.h"
#include "storage/sessions/session_store.h"

namespace enfilade::server {

// The one place that rearranges a site's maps: renders the layers that move from their submaps in the new frames,
// applies everything in one transaction, and marks the graph as changed, so that this server's answers include it
// immediately and watchers are told. Thread-safe.
class Rearranger {
 public:
  struct Stores {
    const storage::SessionStore& sessions;
    const storage::MappingStore& mappings;
    const storage::MapReader& maps;
    const storage::RevisionStore& revisions;
    const storage::BlobStore& blobs;
    const storage::RearrangementStore& rearrangements;
  };

  // All must outlive it. `edits`: what people have edited goes with the maps; null: nobody has.
  Rearranger(const Stores& stores, const slam::SlamProfiles& profiles, SiteGraphs& graphs,
             const MapEdits* edits = nullptr)
      : stores_(stores), profiles_(profiles), graphs_(graphs), edits_(edits) {}

  // Applies what was decided by the graph at `graph_version`, under the site's lease, which the caller holds and keeps.
  // `by_people`: RearrangementChange::by_people.
  // ABORTED if the graph has changed since or the lease is lost: decide again. Other errors: INVALID_ARGUMENT
  // (rearrange::Validate); RearrangementStore::Apply.
  absl::StatusOr<storage::StoredRearrangement> Apply(const storage::CallContext& context,
                                                     const storage::SiteLease& lease,
                                                     const rearrange::Rearrangement& rearrangement,
                                                     std::int64_t graph_version, bool by_people = false) const;
  // As RearrangementStore::Undo.
  absl::StatusOr<storage::StoredRearrangement> Undo(const storage::CallContext& context,
                                                    const storage::SiteLease& lease,
                                                    const rearrange::RearrangementId& id) const;

 private:
  void RecomposeEdited(const storage::CallContext& context, const SiteId& site,
                       const storage::StoredRearrangement& undone) const;

  const Stores stores_;
  const slam::SlamProfiles& profiles_;
  SiteGraphs& graphs_;
  const MapEdits* const edits_;
};

}  // namespace enfilade::server
