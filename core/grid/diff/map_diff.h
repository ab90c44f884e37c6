// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"
#include "core/grid/files/rgb_image.h"
#include "core/grid/map_raster.h"
#include "core/grid/raster_pyramid.h"

namespace enfilade::grid {

// What came and went between two rasters of a map, cell by cell. Cells are compared by their CellClass, which the
// thresholds of each raster decide. Two rasters whose cells lie on one another are compared as they are; others are
// resampled to the lattice of the map's frame, with the coarser one's cells (ResampleToLattice).

// Cells that touch one another, at a side or a corner, and have changed.
struct MapDiffRegion {
  std::array<Eigen::Vector2d, 4> box;  // m, map frame: the corners of the box around it, counter-clockwise
  std::int64_t cells = 0;
  std::array<std::int64_t, 3> to{};  // by the CellClass that they have become
};

// One pixel for `cells_per_pixel` x `cells_per_pixel` cells, of which what has changed most wins.
struct MapDiffPicture {
  RgbImage image;
  int cells_per_pixel = 1;
  Pose2 T_map_picture;  // of the lower-left corner
};

struct MapDiff {
  double resolution = 0.0;              // m, of the cells that were compared
  std::array<std::int64_t, 9> cells{};  // 3 * from + to, by CellClass, in the box around both rasters
  std::int64_t region_count = 0;
  std::vector<MapDiffRegion> regions;  // the largest first
  std::optional<MapDiffPicture> picture;
  std::string geojson;

  // Of all cells.
  std::int64_t changed_cells() const;
};

struct MapDiffOptions {
  // At most so many regions, and so many features of the GeoJSON: the largest.
  std::size_t max_regions = 100;
  // What came (is occupied now) is green, what went (was occupied) red, what became unknown grey; all else is pale.
  // Larger maps have fewer pixels.
  bool with_picture = false;
  int max_picture_side = 4096;
  // A FeatureCollection (RFC 7946, but in m of the map's frame): outlines of occupied cells that came or went and touch
  // one another, with `change` ("came" or "went"), `cells` and `area_m2`.
  bool with_geojson = false;
};

// A raster as it is stored: SplitIntoTiles, with the digests of the tiles.
struct StoredTiles {
  std::string header;
  RasterPyramid::Level tiles;
};
// Gives the bytes of tiles by their digest, of all that are asked for.
using LoadTiles =
    std::function<absl::StatusOr<std::map<std::string, std::string>>(const std::vector<std::string>& sha256)>;

// Tiles that both rasters have are read once and not compared. FAILED_PRECONDITION: the rasters are so far apart that
// one around both would have more than kMaxRasterCells. RESOURCE_EXHAUSTED: they differ in more places than
// ChangedRuns::kMaxRuns, or the GeoJSON would be too large. Errors of `load`; as RasterAssembler.
absl::StatusOr<MapDiff> DiffTiles(const StoredTiles& base, const StoredTiles& revision, const LoadTiles& load,
                                  const MapDiffOptions& options);

// The same of rasters in memory, which must be valid.
absl::StatusOr<MapDiff> DiffRasters(const MapRaster& base, const MapRaster& revision, const MapDiffOptions& options);

}  // namespace enfilade::grid
