// SPDX-License-Identifier: Apache-2.0
#include "server/app/rasters/raster_pyramids.h"

#include <algorithm>
#include <stop_token>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "absl/cleanup/cleanup.h"
#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "core/grid/raster_header.h"
#include "core/grid/raster_pyramid.h"
#include "core/grid/tiled_raster.h"

namespace enfilade::server {
namespace {

using grid::RasterPyramid;

constexpr std::int64_t kPyramidPortionBytes = 8LL << 20;

// The tiles of zoom 0, and where they lie.
struct DisplayTiles {
  bool display_only = false;
  grid::CellIndex lattice_min;
  RasterPyramid::Level tiles;
  std::map<std::string, std::string> made;  // bytes by digest, of tiles that are not stored
};

absl::StatusOr<grid::MapRaster> ReadRaster(const storage::RevisionStore& store, const storage::CallContext& context,
                                           const storage::MapRevision& revision) {
  ENFILADE_ASSIGN_OR_RETURN(auto assembler, grid::RasterAssembler::Create(revision.raster_header));
  std::optional<storage::TileKey> after;
  while (true) {
    ENFILADE_ASSIGN_OR_RETURN(const auto tiles, store.ReadTiles(context, revision, after, kPyramidPortionBytes));
    if (tiles.empty()) return std::move(assembler).Finish();
    for (const storage::Tile& tile : tiles) {
      ENFILADE_RETURN_IF_ERROR(assembler.Add({tile.key.row, tile.key.column}, tile.data));
    }
    after = tiles.back().key;
  }
}

// Of a map in another form: what its cells are read as.
absl::StatusOr<DisplayTiles> Convert(const grid::MapRaster& raster) {
  DisplayTiles display;
  display.display_only = true;
  const grid::TiledRaster tiled = grid::SplitIntoTiles(grid::FromOccupancyGrid(grid::ToOccupancyGrid(raster)));
  ENFILADE_ASSIGN_OR_RETURN(const grid::RasterHeader header, grid::DecodeRasterHeader(tiled.header));
  display.lattice_min = header.lattice_min;
  for (const auto& [index, bytes] : tiled.tiles) {
    std::string digest = Sha256(bytes);
    display.made.emplace(digest, bytes);
    display.tiles.emplace(index, std::move(digest));
  }
  return display;
}

}  // namespace

absl::StatusOr<storage::StoredPyramid> RasterPyramids::Get(const storage::CallContext& context,
                                                           const storage::MapRevision& revision) {
  ENFILADE_ASSIGN_OR_RETURN(auto stored, pyramids_.Find(context, revision.site, revision.map, revision.number));
  if (stored) return *std::move(stored);
  const Key key{revision.site, revision.map, revision.number};
  ENFILADE_RETURN_IF_ERROR(AwaitTurn(context, key));
  const absl::Cleanup end_turn = [this, &key] {
    MutexLock lock(mutex_);
    being_made_.erase(key);
    changed_.NotifyAll();
  };
  return FindOrMake(context, revision);
}

absl::Status RasterPyramids::AwaitTurn(const storage::CallContext& context, const Key& key) {
  const std::stop_callback on_cancel(context.cancellation, [this] {
    MutexLock lock(mutex_);
    changed_.NotifyAll();
  });
  MutexLock lock(mutex_);
  while (!being_made_.insert(key).second) {
    if (context.cancellation.stop_requested()) return absl::CancelledError("the caller no longer waits");
    if (!changed_.WaitUntil(mutex_, context.deadline)) {
      return absl::DeadlineExceededError("the deadline passed while the tiles were made for another call");
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<storage::StoredPyramid> RasterPyramids::FindOrMake(const storage::CallContext& context,
                                                                  const storage::MapRevision& revision) const {
  const SiteId& site = revision.site;
  const MapId& map = revision.map;
  ENFILADE_ASSIGN_OR_RETURN(auto made, pyramids_.Find(context, site, map, revision.number));
  if (made) return *std::move(made);
  ENFILADE_ASSIGN_OR_RETURN(const grid::RasterHeader header, grid::DecodeRasterHeader(revision.raster_header));
  DisplayTiles display;
  if (std::holds_alternative<grid::OccupancyCells>(header.raster.cells)) {
    display.lattice_min = header.lattice_min;
    ENFILADE_ASSIGN_OR_RETURN(display.tiles, pyramids_.ListTiles(context, site, map, revision.number));
  } else {
    ENFILADE_ASSIGN_OR_RETURN(const grid::MapRaster raster, ReadRaster(revisions_, context, revision));
    ENFILADE_ASSIGN_OR_RETURN(display, Convert(raster));
  }
  storage::StoredPyramid before;
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t number, pyramids_.FindBefore(context, site, map, revision.number));
  if (number != 0) {
    ENFILADE_ASSIGN_OR_RETURN(auto earlier, pyramids_.Find(context, site, map, number));
    if (earlier) before = *std::move(earlier);
  }
  const grid::LoadTile load = [&](std::string_view sha256) -> absl::StatusOr<std::string> {
    const auto converted = display.made.find(std::string(sha256));
    if (converted != display.made.end()) return converted->second;
    return blobs_.Get(context, site, sha256);
  };
  ENFILADE_ASSIGN_OR_RETURN(RasterPyramid pyramid, grid::BuildPyramid(display.tiles, before.levels, load));
  storage::StoredPyramid result;
  result.display_only = display.display_only;
  result.lattice_min = display.lattice_min;
  ENFILADE_ASSIGN_OR_RETURN(result.thumbnail, grid::MakeThumbnail(pyramid, display.lattice_min, revision.geometry.width,
                                                                  revision.geometry.height, load));
  result.levels = pyramid.levels;
  display.made.merge(pyramid.made);
  ENFILADE_RETURN_IF_ERROR(Store(context, revision, result, display.made));
  metrics_.CountRasterPyramidMade();
  return result;
}

absl::Status RasterPyramids::Store(const storage::CallContext& context, const storage::MapRevision& revision,
                                   const storage::StoredPyramid& pyramid,
                                   const std::map<std::string, std::string>& made) const {
  std::vector<storage::BlobView> blobs;
  std::size_t bytes = 0;
  for (const auto& [sha256, data] : made) {
    blobs.push_back({sha256, data});
    bytes += data.size();
    if (bytes < kPyramidPortionBytes) continue;
    ENFILADE_RETURN_IF_ERROR(blobs_.Put(context, revision.site, blobs));
    blobs.clear();
    bytes = 0;
  }
  return pyramids_.Add(context, revision.site, revision.map, revision.number, pyramid, blobs);
}

}  // namespace enfilade::server
