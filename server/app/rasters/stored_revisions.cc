// SPDX-License-Identifier: Apache-2.0
#include "server/app/rasters/stored_revisions.h"

#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"

namespace enfilade::server {
namespace {

// All of them: without one, what is left would look like another raster.
absl::StatusOr<grid::RasterPyramid::Level> ListAllTiles(const storage::CallContext& context,
                                                        const storage::PyramidStore& pyramids,
                                                        const storage::MapRevision& revision) {
  ENFILADE_ASSIGN_OR_RETURN(grid::RasterPyramid::Level tiles,
                            pyramids.ListTiles(context, revision.site, revision.map, revision.number));
  if (static_cast<std::int64_t>(tiles.size()) == revision.tile_count) return tiles;
  return NotFound("{}/revisions/{} was deleted while it was read", NameOf(revision.site, revision.map),
                  revision.number);
}

}  // namespace

absl::StatusOr<storage::MapRevision> RestoreRevision(const storage::CallContext& context,
                                                     const storage::RevisionStore& revisions,
                                                     const storage::PyramidStore& pyramids,
                                                     const storage::MapRevision& older) {
  ENFILADE_ASSIGN_OR_RETURN(const grid::RasterPyramid::Level tiles, ListAllTiles(context, pyramids, older));
  storage::NewRevision restored;
  restored.source = storage::RevisionSource::kRestored;
  restored.geometry = older.geometry;
  restored.raster_header = older.raster_header;
  restored.content_sha256 = older.content_sha256;
  for (const auto& [index, sha256] : tiles) restored.tiles.push_back({{index.row, index.column}, sha256});
  return revisions.Add(context, older.site, older.map, restored, {});
}

absl::StatusOr<grid::MapDiff> DiffRevisions(const storage::CallContext& context, const storage::PyramidStore& pyramids,
                                            const storage::BlobStore& blobs, const storage::MapRevision& base,
                                            const storage::MapRevision& revision, const grid::MapDiffOptions& options) {
  grid::StoredTiles before{base.raster_header, {}};
  grid::StoredTiles after{revision.raster_header, {}};
  ENFILADE_ASSIGN_OR_RETURN(before.tiles, ListAllTiles(context, pyramids, base));
  ENFILADE_ASSIGN_OR_RETURN(after.tiles, ListAllTiles(context, pyramids, revision));
  const grid::LoadTiles load = [&](const std::vector<std::string>& sha256) {
    return blobs.GetAll(context, base.site, sha256);
  };
  return grid::DiffTiles(before, after, load, options);
}

}  // namespace enfilade::server
