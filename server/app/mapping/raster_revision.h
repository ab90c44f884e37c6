// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/grid/map_raster.h"
#include "storage/blob_store.h"
#include "storage/call_context.h"
#include "storage/revision_store.h"

namespace enfilade::server {

// A raster in the pieces in which it is stored.
struct RasterRevision {
  storage::NewRevision revision;
  std::vector<storage::Tile> tiles;  // with their bytes; those of `revision.tiles`
};

absl::StatusOr<RasterRevision> ToRevision(const grid::MapRaster& raster);

// Of the header and of every tile with its place: equal hashes, equal rasters.
std::string ContentHash(const std::string& header, const std::vector<storage::TileRef>& tiles);

// What a raster says of occupancy, on the lattice of the map's frame. FAILED_PRECONDITION where it would be too large.
absl::StatusOr<grid::OccupancyGrid> OnMapLattice(const grid::MapRaster& raster, double resolution);

// Stores the tiles' bytes in portions, but for those that are in `known` (by SHA-256).
absl::Status PutTiles(const storage::CallContext& context, const storage::BlobStore& blobs, const SiteId& site,
                      const RasterRevision& raster, const std::set<std::string>& known);

// The raster of a stored revision. DATA_LOSS where its pieces do not fit.
absl::StatusOr<grid::MapRaster> ReadRaster(const storage::CallContext& context, const storage::RevisionStore& revisions,
                                           const storage::MapRevision& revision);

}  // namespace enfilade::server
