// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "storage/maps/revision_store.h"
#include "storage/postgres/driver/pool.h"

namespace enfilade::storage::postgres {

class RevisionStore final : public storage::RevisionStore {
 public:
  explicit RevisionStore(Pool& pool) : pool_(pool) {}

  absl::StatusOr<MapRevision> Add(const CallContext& context, const SiteId& site, const MapId& map,
                                  const NewRevision& revision, absl::Span<const BlobView> blobs) const override;
  absl::StatusOr<MapRevision> Get(const CallContext& context, const SiteId& site, const MapId& map,
                                  std::int64_t number) const override;
  absl::StatusOr<std::vector<MapRevision>> List(const CallContext& context, const SiteId& site, const MapId& map,
                                                std::int64_t before, int limit) const override;
  absl::StatusOr<MapRevision> Tag(const CallContext& context, const SiteId& site, const MapId& map, std::int64_t number,
                                  const std::string& tag) const override;
  absl::StatusOr<LayersBeside> ReadLayersBeside(const CallContext& context, const SiteId& site, const MapId& map,
                                                const SessionId& session) const override;
  absl::StatusOr<LayersBeside> ReadRunsBeside(const CallContext& context, const SiteId& site, const MapId& map,
                                              const SessionId& session, double resolution) const override;
  absl::Status AddRun(const CallContext& context, const SiteId& site, const MapId& map,
                      const NewLayerRun& run) const override;
  absl::StatusOr<OrphanedLayers> ReadOrphanedLayers(const CallContext& context, const SiteId& site, const MapId& map,
                                                    int least, int limit) const override;
  absl::Status MergeLayers(const CallContext& context, const SiteId& site, const MapId& map,
                           const NewLayerRun& merged) const override;
  absl::StatusOr<std::vector<Tile>> ReadTiles(const CallContext& context, const MapRevision& revision,
                                              std::optional<TileKey> after, std::int64_t max_bytes) const override;
  absl::StatusOr<std::optional<StoredRaster>> ReadEvidence(const CallContext& context, const SiteId& site,
                                                           const MapId& map) const override;
  absl::StatusOr<std::vector<edit::Publication>> ReadPublications(const CallContext& context, const SiteId& site,
                                                                  const MapId& map, std::int64_t after,
                                                                  std::int64_t up_to) const override;

 private:
  Pool& pool_;
};

}  // namespace enfilade::storage::postgres
