// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "storage/maps/revision_store.h"

namespace enfilade::server {

// Another store, for tests that change or count some of its calls.
class ForwardingRevisionStore : public storage::RevisionStore {
 public:
  explicit ForwardingRevisionStore(const storage::RevisionStore& store) : store_(store) {}

  absl::StatusOr<storage::MapRevision> Add(const storage::CallContext& context, const SiteId& site, const MapId& map,
                                           const storage::NewRevision& revision,
                                           absl::Span<const storage::BlobView> blobs) const override {
    return store_.Add(context, site, map, revision, blobs);
  }
  absl::StatusOr<storage::MapRevision> Get(const storage::CallContext& context, const SiteId& site, const MapId& map,
                                           std::int64_t number) const override {
    return store_.Get(context, site, map, number);
  }
  absl::StatusOr<std::vector<storage::MapRevision>> List(const storage::CallContext& context, const SiteId& site,
                                                         const MapId& map, std::int64_t before,
                                                         int limit) const override {
    return store_.List(context, site, map, before, limit);
  }
  absl::StatusOr<storage::MapRevision> Tag(const storage::CallContext& context, const SiteId& site, const MapId& map,
                                           std::int64_t number, const std::string& tag) const override {
    return store_.Tag(context, site, map, number, tag);
  }
  absl::StatusOr<storage::LayersBeside> ReadLayersBeside(const storage::CallContext& context, const SiteId& site,
                                                         const MapId& map, const SessionId& session) const override {
    return store_.ReadLayersBeside(context, site, map, session);
  }
  absl::StatusOr<storage::LayersBeside> ReadRunsBeside(const storage::CallContext& context, const SiteId& site,
                                                       const MapId& map, const SessionId& session,
                                                       double resolution) const override {
    return store_.ReadRunsBeside(context, site, map, session, resolution);
  }
  absl::Status AddRun(const storage::CallContext& context, const SiteId& site, const MapId& map,
                      const storage::NewLayerRun& run) const override {
    return store_.AddRun(context, site, map, run);
  }
  absl::StatusOr<storage::OrphanedLayers> ReadOrphanedLayers(const storage::CallContext& context, const SiteId& site,
                                                             const MapId& map, int least, int limit) const override {
    return store_.ReadOrphanedLayers(context, site, map, least, limit);
  }
  absl::Status MergeLayers(const storage::CallContext& context, const SiteId& site, const MapId& map,
                           const storage::NewLayerRun& merged) const override {
    return store_.MergeLayers(context, site, map, merged);
  }
  absl::StatusOr<std::vector<storage::Tile>> ReadTiles(const storage::CallContext& context,
                                                       const storage::MapRevision& revision,
                                                       std::optional<storage::TileKey> after,
                                                       std::int64_t max_bytes) const override {
    return store_.ReadTiles(context, revision, after, max_bytes);
  }

 private:
  const storage::RevisionStore& store_;
};

}  // namespace enfilade::server
