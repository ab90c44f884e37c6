// SPDX-License-Identifier: Apache-2.0
#include "storage/maps/revision_store.h"

#include <thread>

#include "tests/contract/storage/suite/contract_test.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// A raster of rows x columns tiles, each with content of its own, and the blobs of it.
struct Raster {
  storage::NewRevision revision;
  std::vector<TestBlob> blobs;

  std::vector<storage::BlobView> views() const {
    std::vector<storage::BlobView> result;
    for (const TestBlob& blob : blobs) result.push_back(blob.view());
    return result;
  }
};

Raster MakeRaster(int rows, int columns, const std::string& salt, std::size_t tile_bytes = 10) {
  Raster raster;
  raster.revision.source = storage::RevisionSource::kImport;
  raster.revision.geometry = {0.05, {-12.345678901234567, 1.0 / 3, 0.7}, columns * 256, rows * 256};
  raster.revision.raster_header = std::string("\0header", 7) + salt;
  raster.revision.content_sha256 = TestBlob(salt).sha256();
  // In another order than that in which they come back.
  for (int column = columns - 1; column >= 0; --column) {
    for (int row = 0; row < rows; ++row) {
      std::string data = salt + std::to_string(row) + "," + std::to_string(column) + ";";
      data.resize(tile_bytes, '.');
      raster.blobs.emplace_back(std::move(data));
      raster.revision.tiles.push_back({{row, column}, raster.blobs.back().sha256()});
    }
  }
  return raster;
}

class RevisionStoreTest : public StoreContractTest {
 protected:
  absl::StatusOr<storage::MapRevision> Add(const Raster& raster) {
    return revisions_.Add(Soon(), site_, map_, raster.revision, raster.views());
  }
};

TEST_F(RevisionStoreTest, GivesBackWhatWasStoredAndMakesItCurrent) {
  const Raster raster = MakeRaster(2, 3, "one");
  ASSERT_OK_AND_ASSIGN(const storage::MapRevision added, Add(raster));
  ASSERT_OK_AND_ASSIGN(const storage::MapRevision current, revisions_.Get(Soon(), site_, map_, 0));
  for (const storage::MapRevision& revision : {added, current}) {
    EXPECT_EQ(revision.number, 1);
    EXPECT_EQ(revision.source, storage::RevisionSource::kImport);
    EXPECT_EQ(revision.session, std::nullopt);
    EXPECT_EQ(revision.geometry, raster.revision.geometry);
    EXPECT_EQ(revision.raster_header, raster.revision.raster_header);
    EXPECT_EQ(revision.content_sha256, raster.revision.content_sha256);
    EXPECT_EQ(revision.tile_count, 6);
    EXPECT_EQ(revision.tile_bytes, 60);
  }
  ASSERT_OK_AND_ASSIGN(const storage::Map map, maps_.Get(Soon(), site_, map_));
  EXPECT_EQ(map.current_revision, 1);
  EXPECT_EQ(map.state, storage::MapState::kReady);
  ASSERT_OK_AND_ASSIGN(const auto tiles, revisions_.ReadTiles(Soon(), current, std::nullopt, 1 << 20));
  ASSERT_THAT(tiles, SizeIs(6));
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(tiles[i].key, (storage::TileKey{static_cast<int>(i) / 3, static_cast<int>(i) % 3}));
  }
}

TEST_F(RevisionStoreTest, ARevisionHasOneTagUntilThatIsRemoved) {
  ASSERT_OK(Add(MakeRaster(1, 1, "one")));
  ASSERT_OK(Add(MakeRaster(1, 1, "two")));
  ASSERT_OK(revisions_.Tag(Soon(), site_, map_, 1, "before"));
  ASSERT_OK_AND_ASSIGN(const storage::MapRevision tagged, revisions_.Tag(Soon(), site_, map_, 1, "as built"));
  EXPECT_EQ(tagged.number, 1);
  EXPECT_EQ(tagged.tag, "as built");
  ASSERT_OK_AND_ASSIGN(const auto revisions, revisions_.List(Soon(), site_, map_, 0, 10));
  ASSERT_THAT(revisions, SizeIs(2));
  EXPECT_EQ(revisions[0].tag, "");
  EXPECT_EQ(revisions[1].tag, "as built");
  ASSERT_OK(revisions_.Tag(Soon(), site_, map_, 1, ""));
  ASSERT_OK_AND_ASSIGN(const storage::MapRevision first, revisions_.Get(Soon(), site_, map_, 1));
  EXPECT_EQ(first.tag, "");
  EXPECT_CODE(revisions_.Tag(Soon(), site_, map_, 3, "x"), absl::StatusCode::kNotFound);
  EXPECT_CODE(revisions_.Tag(Soon(), site_, MapId("nowhere"), 1, "x"), absl::StatusCode::kNotFound);
}

TEST_F(RevisionStoreTest, ReadsTilesInPortionsInTheOrderOfTheRaster) {
  const Raster raster = MakeRaster(7, 5, "one", 1000);
  ASSERT_OK_AND_ASSIGN(const storage::MapRevision added, Add(raster));
  std::vector<storage::Tile> all;
  std::optional<storage::TileKey> after;
  int portions = 0;
  while (true) {
    ASSERT_OK_AND_ASSIGN(const auto tiles, revisions_.ReadTiles(Soon(), added, after, 3500));
    if (tiles.empty()) break;
    EXPECT_THAT(tiles, SizeIs(::testing::Le(4U)));
    all.insert(all.end(), tiles.begin(), tiles.end());
    after = tiles.back().key;
    ++portions;
  }
  EXPECT_EQ(portions, 9);
  ASSERT_THAT(all, SizeIs(35));
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].key, (storage::TileKey{static_cast<int>(i) / 5, static_cast<int>(i) % 5}));
    EXPECT_THAT(all[i].data, ::testing::StartsWith("one" + std::to_string(i / 5) + "," + std::to_string(i % 5) + ";"));
    EXPECT_EQ(TestBlob(all[i].data).sha256(), all[i].sha256);
  }
  ASSERT_OK_AND_ASSIGN(const auto one, revisions_.ReadTiles(Soon(), added, std::nullopt, 1));
  EXPECT_THAT(one, SizeIs(1));
}

TEST_F(RevisionStoreTest, RevisionsCountAndShareTheirTiles) {
  const Raster first = MakeRaster(1, 2, "one");
  ASSERT_OK(Add(first));
  Raster second = MakeRaster(1, 1, "two");
  second.revision.tiles.push_back(first.revision.tiles[0]);  // column 1, unchanged
  ASSERT_OK_AND_ASSIGN(const storage::MapRevision added, Add(second));
  EXPECT_EQ(added.number, 2);
  EXPECT_EQ(backend_->CountBlobs(), 3);
  ASSERT_OK_AND_ASSIGN(const auto revisions, revisions_.List(Soon(), site_, map_, 0, 10));
  ASSERT_THAT(revisions, SizeIs(2));
  EXPECT_EQ(revisions[0].number, 2);
  ASSERT_OK_AND_ASSIGN(const auto earlier, revisions_.List(Soon(), site_, map_, 2, 10));
  ASSERT_THAT(earlier, SizeIs(1));
  EXPECT_EQ(earlier[0].number, 1);
  EXPECT_CODE(revisions_.List(Soon(), site_, MapId("m9"), 0, 10), absl::StatusCode::kNotFound);
}

TEST_F(RevisionStoreTest, TheSameContentAgainIsTheSameRevision) {
  const Raster raster = MakeRaster(1, 2, "one");
  ASSERT_OK(Add(raster));
  ASSERT_OK_AND_ASSIGN(const storage::MapRevision repeated, Add(raster));
  EXPECT_EQ(repeated.number, 1);
  ASSERT_OK(Add(MakeRaster(1, 2, "two")));
  ASSERT_OK_AND_ASSIGN(const storage::MapRevision back, Add(raster));
  EXPECT_EQ(back.number, 3);
}

TEST_F(RevisionStoreTest, StoresNothingWhereATileIsMissingOrGivenTwice) {
  Raster missing = MakeRaster(1, 2, "one");
  missing.blobs.pop_back();
  EXPECT_STATUS(Add(missing), absl::StatusCode::kFailedPrecondition, HasSubstr("blob is not stored"));
  Raster twice = MakeRaster(1, 2, "one");
  twice.revision.tiles[1].key = twice.revision.tiles[0].key;
  EXPECT_STATUS(Add(twice), absl::StatusCode::kInvalidArgument, HasSubstr("twice"));
  Raster broken = MakeRaster(1, 1, "one");
  broken.revision.geometry.resolution = 0;
  EXPECT_CODE(Add(broken), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(revisions_.Get(Soon(), site_, map_, 0), absl::StatusCode::kNotFound);
  EXPECT_EQ(backend_->CountBlobs(), 0);
  EXPECT_CODE(revisions_.Add(Soon(), site_, MapId("m9"), missing.revision, {}), absl::StatusCode::kNotFound);
}

TEST_F(RevisionStoreTest, AnEmptyRasterHasNoTiles) {
  ASSERT_OK_AND_ASSIGN(const storage::MapRevision added, Add(MakeRaster(0, 0, "none")));
  EXPECT_EQ(added.tile_count, 0);
  ASSERT_OK_AND_ASSIGN(const auto tiles, revisions_.ReadTiles(Soon(), added, std::nullopt, 1000));
  EXPECT_THAT(tiles, IsEmpty());
}

TEST_F(RevisionStoreTest, NumbersAreGivenOnceToManyWriters) {
  std::vector<absl::StatusOr<storage::MapRevision>> added(6, absl::UnknownError("not run"));
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < added.size(); ++t) {
    threads.emplace_back([&, t] { added[t] = Add(MakeRaster(2, 2, "writer " + std::to_string(t))); });
  }
  for (std::thread& thread : threads) thread.join();
  std::set<std::int64_t> numbers;
  for (const auto& revision : added) {
    ASSERT_OK(revision);
    numbers.insert(revision->number);
  }
  EXPECT_EQ(numbers, (std::set<std::int64_t>{1, 2, 3, 4, 5, 6}));
}

TEST_F(RevisionStoreTest, PortionsOfEverySizeGiveEachTileOnce) {
  const Raster raster = MakeRaster(4, 4, "one", 100);
  ASSERT_OK_AND_ASSIGN(const storage::MapRevision added, Add(raster));
  for (const std::int64_t max_bytes : {1, 99, 100, 101, 350, 1600, 1 << 20}) {
    std::vector<storage::TileKey> keys;
    std::optional<storage::TileKey> after;
    while (true) {
      ASSERT_OK_AND_ASSIGN(const auto tiles, revisions_.ReadTiles(Soon(), added, after, max_bytes));
      if (tiles.empty()) break;
      std::int64_t bytes = 0;
      for (const storage::Tile& tile : tiles) {
        keys.push_back(tile.key);
        bytes += static_cast<std::int64_t>(tile.data.size());
      }
      EXPECT_LT(bytes - static_cast<std::int64_t>(tiles.back().data.size()), max_bytes);
      after = tiles.back().key;
    }
    ASSERT_THAT(keys, SizeIs(16)) << max_bytes;
    EXPECT_TRUE(std::is_sorted(keys.begin(), keys.end()));
  }
}

TEST_F(RevisionStoreTest, WhatIsNotThereHasNoTilesAndNoRevision) {
  ASSERT_OK_AND_ASSIGN(storage::MapRevision added, Add(MakeRaster(1, 1, "one")));
  EXPECT_CODE(revisions_.Get(Soon(), site_, map_, 2), absl::StatusCode::kNotFound);
  EXPECT_CODE(revisions_.Get(Soon(), site_, MapId("m9"), 0), absl::StatusCode::kNotFound);
  added.number = 2;
  ASSERT_OK_AND_ASSIGN(const auto later, revisions_.ReadTiles(Soon(), added, std::nullopt, 1000));
  EXPECT_THAT(later, IsEmpty());
  added.map = MapId("m9");
  ASSERT_OK_AND_ASSIGN(const auto elsewhere, revisions_.ReadTiles(Soon(), added, std::nullopt, 1000));
  EXPECT_THAT(elsewhere, IsEmpty());
  ASSERT_OK_AND_ASSIGN(const auto layers, revisions_.ReadLayersBeside(Soon(), site_, MapId("m9"), SessionId("s")));
  EXPECT_THAT(layers.below, IsEmpty());
  EXPECT_EQ(layers.version, 0);
}

}  // namespace
}  // namespace enfilade::testing
