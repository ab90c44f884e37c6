// SPDX-License-Identifier: Apache-2.0
#include "server/app/mapping/raster_revision.h"

#include <gmock/gmock.h>

#include <random>

#include "core/base/sha256.h"
#include "core/grid/overlay.h"
#include "core/grid/tiled_raster.h"
#include "server/app/mapping/layer_overlay.h"
#include "tests/fakes/in_memory_stores.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/server/app/test_values.h"

namespace enfilade::server {
namespace {

using ::testing::HasSubstr;

// Cells of 0.05 m with the lower-left corner at cell (x, y) of the map's lattice. Random values, none unknown.
grid::OccupancyGrid RandomGrid(int width, int height, int x, int y, unsigned seed) {
  grid::OccupancyGrid grid;
  grid.geometry.width = width;
  grid.geometry.height = height;
  grid.geometry.resolution = 0.05;
  grid.geometry.T_map_grid = {0.05 * x, 0.05 * y, 0.0};
  std::minstd_rand random(seed);
  for (int i = 0; i < width * height; ++i) grid.cells.push_back(random() % 2 == 0 ? 1 : 255);
  return grid;
}

class RasterRevisionTest : public ::testing::Test {
 protected:
  RasterRevisionTest() {
    stores_.database.AddSite(site_);
    EXPECT_OK(stores_.maps.Create(Soon(), MakeMap(site_, "hall"), ""));
  }

  storage::MapRevision Store(const RasterRevision& raster) {
    EXPECT_OK(PutTiles(Soon(), stores_.blobs, site_, raster, {}));
    storage::NewRevision revision = raster.revision;
    revision.source = storage::RevisionSource::kImport;
    auto stored = stores_.revisions.Add(Soon(), site_, MapId("hall"), revision, {});
    EXPECT_OK(stored);
    return *stored;
  }
  // A layer as it is stored in a map.
  storage::MapLayer Layer(const grid::OccupancyGrid& grid) {
    auto raster = ToRevision(grid::FromOccupancyGrid(grid));
    EXPECT_OK(raster);
    EXPECT_OK(PutTiles(Soon(), stores_.blobs, site_, *raster, {}));
    return {std::nullopt, {raster->revision.raster_header, raster->revision.tiles}};
  }

  const SiteId site_{"campus"};
  testing::InMemoryStores stores_;
};

TEST_F(RasterRevisionTest, AStoredRasterIsReadBackExactly) {
  const grid::OccupancyGrid grid = RandomGrid(700, 300, -40, 20, 1);
  ASSERT_OK_AND_ASSIGN(const RasterRevision raster, ToRevision(grid::FromOccupancyGrid(grid)));
  EXPECT_EQ(raster.tiles.size(), raster.revision.tiles.size());
  EXPECT_GT(raster.tiles.size(), 3U);
  ASSERT_OK_AND_ASSIGN(const grid::MapRaster read, ReadRaster(Soon(), stores_.revisions, Store(raster)));
  ASSERT_OK_AND_ASSIGN(const grid::OccupancyGrid back, OnMapLattice(read, 0.05));
  EXPECT_EQ(back.cells, grid.cells);
  EXPECT_EQ(back.geometry.width, 700);
}

TEST_F(RasterRevisionTest, TheContentHashTellsRastersApart) {
  const grid::OccupancyGrid grid = RandomGrid(300, 300, 0, 0, 1);
  const auto hash = [](const grid::OccupancyGrid& of) {
    return ToRevision(grid::FromOccupancyGrid(of))->revision.content_sha256;
  };
  EXPECT_EQ(hash(grid), hash(grid));
  grid::OccupancyGrid other_cell = grid;
  other_cell.cells[12345] = other_cell.cells[12345] == 1 ? 255 : 1;
  EXPECT_NE(hash(grid), hash(other_cell));
  grid::OccupancyGrid moved = grid;
  moved.geometry.T_map_grid.x += 0.05;
  EXPECT_NE(hash(grid), hash(moved));
  // The same tiles at other places.
  auto tiles = ToRevision(grid::FromOccupancyGrid(grid))->revision.tiles;
  const std::string before = ContentHash("header", tiles);
  std::swap(tiles[0].key, tiles[1].key);
  EXPECT_NE(ContentHash("header", tiles), before);
  EXPECT_NE(ContentHash("other header", tiles), ContentHash("header", tiles));
}

TEST_F(RasterRevisionTest, OnlyUnknownTilesAreStored) {
  grid::OccupancyGrid grid = RandomGrid(600, 256, 0, 0, 1);
  ASSERT_OK_AND_ASSIGN(const RasterRevision first, ToRevision(grid::FromOccupancyGrid(grid)));
  ASSERT_OK(PutTiles(Soon(), stores_.blobs, site_, first, {}));
  const std::int64_t blobs = stores_.database.CountBlobs();
  EXPECT_EQ(blobs, static_cast<std::int64_t>(first.tiles.size()));
  grid.cells[0] = grid.cells[0] == 1 ? 255 : 1;
  ASSERT_OK_AND_ASSIGN(const RasterRevision second, ToRevision(grid::FromOccupancyGrid(grid)));
  std::set<std::string> known;
  for (const storage::Tile& tile : first.tiles) known.insert(tile.sha256);
  ASSERT_OK(PutTiles(Soon(), stores_.blobs, site_, second, known));
  EXPECT_EQ(stores_.database.CountBlobs(), blobs + 1) << "one tile has changed";
  stores_.database.FailCalls(absl::UnavailableError("gone"));
  for (const storage::Tile& tile : second.tiles) known.insert(tile.sha256);
  EXPECT_OK(PutTiles(Soon(), stores_.blobs, site_, second, known)) << "nothing to store, no call";
  EXPECT_CODE(PutTiles(Soon(), stores_.blobs, site_, second, {}), absl::StatusCode::kUnavailable);
}

TEST_F(RasterRevisionTest, ARevisionWhoseTilesDoNotFitItsHeaderIsDataLoss) {
  ASSERT_OK_AND_ASSIGN(RasterRevision raster, ToRevision(grid::FromOccupancyGrid(RandomGrid(300, 100, 0, 0, 1))));
  raster.tiles[0].data.resize(raster.tiles[0].data.size() / 2);
  raster.tiles[0].sha256 = Sha256(raster.tiles[0].data);
  raster.revision.tiles[0].sha256 = raster.tiles[0].sha256;
  EXPECT_CODE(ReadRaster(Soon(), stores_.revisions, Store(raster)), absl::StatusCode::kDataLoss);
  storage::MapRevision bad_header = Store(raster);
  bad_header.raster_header = "not a header";
  EXPECT_CODE(ReadRaster(Soon(), stores_.revisions, bad_header), absl::StatusCode::kDataLoss);
}

TEST_F(RasterRevisionTest, AnInvalidRasterIsRefused) {
  grid::OccupancyGrid grid = RandomGrid(10, 10, 0, 0, 1);
  grid.geometry.resolution = 0.0;
  EXPECT_CODE(ToRevision(grid::FromOccupancyGrid(grid)), absl::StatusCode::kInvalidArgument);
}

TEST_F(RasterRevisionTest, LayersAreOverlaidFromTheBottomWithTheSessionsOwnBetween) {
  const grid::OccupancyGrid bottom = RandomGrid(100, 60, 0, 0, 1);
  const grid::OccupancyGrid middle = RandomGrid(100, 60, 30, 10, 2);
  const grid::OccupancyGrid own = RandomGrid(80, 80, -20, -5, 3);
  const grid::OccupancyGrid top = RandomGrid(60, 90, 10, -30, 4);
  LayerOverlay overlay(stores_.blobs, site_);
  const storage::LayersBeside beside{1, {Layer(bottom), Layer(middle)}, {Layer(top)}};
  ASSERT_OK_AND_ASSIGN(const grid::OccupancyGrid composed, overlay.Compose(Soon(), beside, own));
  grid::OccupancyGrid expected = bottom;
  for (const grid::OccupancyGrid* layer : {&middle, &own, &top}) expected = *grid::Overlay(expected, *layer);
  EXPECT_EQ(composed.cells, expected.cells);
  EXPECT_EQ(composed.geometry.width, expected.geometry.width);
}

TEST_F(RasterRevisionTest, OtherLayersAreReadOnceUntilTheyChange) {
  const grid::OccupancyGrid own = RandomGrid(50, 50, 0, 0, 3);
  LayerOverlay overlay(stores_.blobs, site_);
  storage::LayersBeside beside{1, {Layer(RandomGrid(50, 50, 5, 5, 1))}, {}};
  ASSERT_OK(overlay.Compose(Soon(), beside, own));
  const storage::MapLayer changed = Layer(RandomGrid(50, 50, 5, 5, 2));
  stores_.database.FailCalls(absl::UnavailableError("gone"));
  EXPECT_OK(overlay.Compose(Soon(), beside, own));
  beside.above = {changed};
  EXPECT_CODE(overlay.Compose(Soon(), beside, own), absl::StatusCode::kUnavailable);
}

TEST_F(RasterRevisionTest, LayersThatAreTooFarApartAreAnError) {
  LayerOverlay overlay(stores_.blobs, site_);
  const storage::LayersBeside beside{1, {Layer(RandomGrid(50, 50, 2'000'000, 2'000'000, 1))}, {}};
  EXPECT_STATUS(overlay.Compose(Soon(), beside, RandomGrid(50, 50, 0, 0, 2)), absl::StatusCode::kFailedPrecondition,
                HasSubstr("too far apart"));
}

}  // namespace
}  // namespace enfilade::server
