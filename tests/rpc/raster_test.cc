// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include "core/base/sha256.h"
#include "core/grid/raster_pyramid.h"
#include "core/grid/tile_codec.h"
#include "core/grid/tiled_raster.h"
#include "enfilade/v1/raster_service.grpc.pb.h"
#include "storage/postgres/maps/blob_store.h"
#include "storage/postgres/maps/revision_store.h"
#include "tests/rpc/server_test.h"

namespace enfilade::testing {
namespace {

class RasterTest : public ServerTest {
 protected:
  // A free hall of 40 m x 20 m around the map's origin, with a wall of one cell.
  static grid::OccupancyGrid Hall() {
    grid::OccupancyGrid hall;
    hall.geometry = {0.05, {-10.0, -5.0, 0.0}, 800, 400};
    hall.cells.assign(hall.geometry.cell_count(), 20);
    for (int column = 10; column < 790; ++column) hall.cells[hall.geometry.index(column, 177)] = 240;
    return hall;
  }

  void Add(const grid::MapRaster& raster) {
    const grid::TiledRaster tiled = grid::SplitIntoTiles(raster);
    storage::NewRevision revision;
    revision.source = storage::RevisionSource::kImport;
    revision.geometry = raster.geometry;
    revision.raster_header = tiled.header;
    revision.content_sha256 = Sha256(std::to_string(++revisions_made_));
    std::vector<std::string> digests;
    digests.reserve(tiled.tiles.size());
    std::vector<storage::BlobView> blobs;
    for (const auto& [index, bytes] : tiled.tiles) {
      digests.push_back(Sha256(bytes));
      blobs.push_back({digests.back(), bytes});
      revision.tiles.push_back({{index.row, index.column}, digests.back()});
    }
    // The same tile may occur often.
    std::sort(blobs.begin(), blobs.end(), [](const auto& a, const auto& b) { return a.sha256 < b.sha256; });
    blobs.erase(
        std::unique(blobs.begin(), blobs.end(), [](const auto& a, const auto& b) { return a.sha256 == b.sha256; }),
        blobs.end());
    ASSERT_OK(revisions_.Add(Soon(), SiteId("s"), MapId("m"), revision, blobs));
  }

  absl::StatusOr<v1::GetRasterManifestResponse> Manifest(int revision) const {
    v1::GetRasterManifestRequest request;
    request.set_name("sites/s/maps/m/revisions/" + std::to_string(revision));
    return Call(&v1::RasterService::Stub::GetRasterManifest, request);
  }

  absl::StatusOr<std::vector<v1::ReadTilesResponse>> Read(const std::vector<std::string>& digests,
                                                          const std::string& site = "sites/s") const {
    v1::ReadTilesRequest request;
    request.set_parent(site);
    for (const std::string& digest : digests) request.add_sha256(digest);
    grid::TilePacking packing;
    grpc::ClientContext context;
    const auto stub = v1::RasterService::NewStub(connection_->channel());
    const auto stream = stub->ReadTiles(&context, request);
    std::vector<v1::ReadTilesResponse> tiles;
    v1::ReadTilesResponse tile;
    while (stream->Read(&tile)) tiles.push_back(tile);
    const absl::Status status = client::FromGrpcStatus(stream->Finish());
    if (!status.ok()) return status;
    return tiles;
  }

  // The cells of a zoom by column and row of its lattice.
  std::map<std::pair<int, int>, std::uint8_t> CellsOf(const v1::RasterLevel& level) const {
    std::map<std::pair<int, int>, std::uint8_t> cells;
    for (const v1::RasterTile& tile : level.tiles()) {
      const auto read = Read({tile.sha256()});
      EXPECT_OK(read);
      std::vector<std::uint8_t> content(65536);
      EXPECT_OK(grid::TilePacking().Unpack("\1" + read->at(0).zstd_cells(), absl::MakeSpan(content)));
      for (int i = 0; i < 65536; ++i) {
        cells[{tile.column() * 256 + i % 256, tile.row() * 256 + i / 256}] = content[static_cast<std::size_t>(i)];
      }
    }
    return cells;
  }

  int revisions_made_ = 0;
  const storage::postgres::RevisionStore revisions_{*pool_};
  const storage::postgres::BlobStore blobs_{*pool_};
};

TEST_F(RasterTest, AManifestHasTilesOfAllZoomsAndAWallIsInEach) {
  Add(grid::FromOccupancyGrid(Hall()));
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM enfilade.raster_pyramids"), "0") << "before anybody looks";
  ASSERT_OK_AND_ASSIGN(const auto manifest, Manifest(1));
  EXPECT_EQ(manifest.revision(), "sites/s/maps/m/revisions/1");
  EXPECT_EQ(manifest.resolution_m(), 0.05);
  EXPECT_EQ(manifest.first_column(), -200);
  EXPECT_EQ(manifest.first_row(), -100);
  EXPECT_EQ(manifest.width(), 800);
  EXPECT_EQ(manifest.height(), 400);
  EXPECT_NEAR(manifest.pose_map_tiles().x(), 0.0, 1e-9);
  EXPECT_FALSE(manifest.display_only());
  ASSERT_EQ(manifest.classes().size(), 256U);
  ASSERT_GE(manifest.levels_size(), 2);
  for (const v1::RasterLevel& level : manifest.levels()) {
    const auto cells = CellsOf(level);
    const int row = 77 >> level.zoom();
    for (const int column : {-190, 0, 300, 589}) {
      const std::uint8_t cell = cells.at({column >> level.zoom(), row});
      EXPECT_EQ(manifest.classes()[cell], 2) << level.zoom();
    }
    EXPECT_EQ(manifest.classes()[cells.at({300 >> level.zoom(), 250 >> level.zoom()})], 1);
  }
  // Tiles of zoom 0 are the stored ones.
  for (const v1::RasterTile& tile : manifest.levels(0).tiles()) {
    ASSERT_OK_AND_ASSIGN(const std::string stored, blobs_.Get(Soon(), SiteId("s"), tile.sha256()));
    ASSERT_OK_AND_ASSIGN(const auto read, Read({tile.sha256()}));
    EXPECT_EQ("\1" + read.at(0).zstd_cells(), stored);
  }
}

TEST_F(RasterTest, ANewRevisionSharesWhatIsUnchanged) {
  grid::OccupancyGrid hall = Hall();
  Add(grid::FromOccupancyGrid(hall));
  ASSERT_OK_AND_ASSIGN(const auto first, Manifest(1));
  hall.cells[hall.geometry.index(799, 399)] = 240;
  Add(grid::FromOccupancyGrid(hall));
  ASSERT_OK_AND_ASSIGN(const auto second, Manifest(2));
  std::set<std::string> known;
  int changed = 0;
  for (const v1::RasterLevel& level : first.levels()) {
    for (const v1::RasterTile& tile : level.tiles()) known.insert(tile.sha256());
  }
  for (const v1::RasterLevel& level : second.levels()) {
    for (const v1::RasterTile& tile : level.tiles()) changed += known.contains(tile.sha256()) ? 0 : 1;
  }
  EXPECT_EQ(changed, second.levels_size());
  ASSERT_OK_AND_ASSIGN(const auto again, Manifest(2));
  EXPECT_EQ(again.SerializeAsString(), second.SerializeAsString());
}

TEST_F(RasterTest, AnImportedImageIsShownAsWhatItIsReadAs) {
  grid::MapRaster image;
  image.geometry = {0.1, {3.0, 4.0, 0.5}, 300, 100};
  grid::GreyCells cells;
  cells.grey.assign(image.geometry.cell_count(), 254);
  cells.grey[image.geometry.index(299, 99)] = 0;
  cells.grey[image.geometry.index(0, 0)] = 205;
  image.cells = cells;
  Add(image);
  ASSERT_OK_AND_ASSIGN(const auto manifest, Manifest(1));
  EXPECT_TRUE(manifest.display_only());
  EXPECT_EQ(manifest.first_column(), 0);
  EXPECT_NEAR(manifest.pose_map_tiles().x(), 3.0, 1e-9);
  EXPECT_NEAR(manifest.pose_map_tiles().yaw(), 0.5, 1e-9);
  const auto shown = CellsOf(manifest.levels(0));
  EXPECT_EQ(manifest.classes()[shown.at({299, 99})], 2);
  EXPECT_EQ(manifest.classes()[shown.at({0, 0})], 0);
  EXPECT_EQ(manifest.classes()[shown.at({7, 7})], 1);
}

TEST_F(RasterTest, OnlyTilesOfManifestsAreRead) {
  Add(grid::FromOccupancyGrid(Hall()));
  ASSERT_OK_AND_ASSIGN(const auto manifest, Manifest(1));
  const std::string digest = manifest.levels(0).tiles(0).sha256();
  ASSERT_OK_AND_ASSIGN(const auto twice, Read({digest, digest}));
  EXPECT_EQ(twice.size(), 1U);
  const std::string secret = "a picture of a place";
  ASSERT_OK(blobs_.Put(Soon(), SiteId("s"), {{Sha256(secret), secret}}));
  EXPECT_CODE(Read({Sha256(secret)}), absl::StatusCode::kNotFound);
  EXPECT_CODE(Read({digest, Sha256("nothing")}), absl::StatusCode::kNotFound);
  EXPECT_CODE(Read({digest}, "sites/nowhere"), absl::StatusCode::kNotFound);
  EXPECT_CODE(Read({"short"}), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(Read({}), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(Read(std::vector<std::string>(257, digest)), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(Manifest(7), absl::StatusCode::kNotFound);
}

TEST_F(RasterTest, ThumbnailsShowWholeMapsPageByPage) {
  Add(grid::FromOccupancyGrid(Hall()));
  v1::ListRasterThumbnailsRequest request;
  request.set_parent("sites/s");
  ASSERT_OK_AND_ASSIGN(const auto list, Call(&v1::RasterService::Stub::ListRasterThumbnails, request));
  ASSERT_EQ(list.thumbnails_size(), 1);
  const v1::RasterThumbnail& thumbnail = list.thumbnails(0);
  EXPECT_EQ(thumbnail.revision(), "sites/s/maps/m/revisions/1");
  EXPECT_NEAR(thumbnail.resolution_m(), 0.8, 1e-9);
  EXPECT_LE(thumbnail.pose_map_thumbnail().x(), -10.0 + 1e-9);
  EXPECT_GT(thumbnail.pose_map_thumbnail().x(), -10.8 - 1e-9);
  ASSERT_EQ(thumbnail.cells().size(), static_cast<std::size_t>(thumbnail.width() * thumbnail.height()));
  const int wall = static_cast<int>((-5.0 + 177.5 * 0.05 - thumbnail.pose_map_thumbnail().y()) / 0.8);
  for (int column = 2; column < thumbnail.width() - 2; ++column) {
    EXPECT_EQ(thumbnail.cells()[static_cast<std::size_t>(wall * thumbnail.width() + column)], 2);
  }
  request.set_level(5);
  ASSERT_OK_AND_ASSIGN(const auto none, Call(&v1::RasterService::Stub::ListRasterThumbnails, request));
  EXPECT_EQ(none.thumbnails_size(), 0);
  request.set_parent("sites/nowhere");
  EXPECT_CODE(Call(&v1::RasterService::Stub::ListRasterThumbnails, request), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace enfilade::testing
