// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/grid/map_raster.h"
#include "storage/call_context.h"
#include "storage/maps/blob_store.h"
#include "storage/maps/revision_store.h"

namespace enfilade::server {

// A raster split into tiles, as it is stored.
struct RasterRevision {
  storage::NewRevision revision;
  std::vector<storage::Tile> tiles;  // those of `revision.tiles`, with their bytes
};

// INVALID_ARGUMENT if the raster is invalid.
absl::StatusOr<RasterRevision> ToRevision(const grid::MapRaster& raster);

// The SHA-256 of the header and of every tile with its place: rasters with equal hashes are equal.
std::string ContentHash(const std::string& header, const std::vector<storage::TileRef>& tiles);

// The raster's occupancy on the lattice of the map's frame, with cells of `resolution` m. FAILED_PRECONDITION if the
// result would be too large.
absl::StatusOr<grid::OccupancyGrid> OnMapLattice(const grid::MapRaster& raster, double resolution);

// Stores the tiles' bytes in portions, except those in `known` (by SHA-256).
absl::Status PutTiles(const storage::CallContext& context, const storage::BlobStore& blobs, const SiteId& site,
                      const RasterRevision& raster, const std::set<std::string>& known);

// Reads the raster of a stored revision. DATA_LOSS if its tiles do not match its header;
// FAILED_PRECONDITION if a newer program stored it; NOT_FOUND if it is deleted meanwhile.
absl::StatusOr<grid::MapRaster> ReadRaster(const storage::CallContext& context, const storage::RevisionStore& revisions,
                                           const storage::MapRevision& revision);

}  // namespace enfilade::server
