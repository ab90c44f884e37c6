// SPDX-License-Identifier: Apache-2.0
#include "storage/maps/pyramid_store.h"

#include <gmock/gmock.h>

#include "storage/sites/maintenance.h"
#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

class PyramidStoreTest : public StoreTest {
 protected:
  PyramidStoreTest() {
    storage::NewRevision revision;
    revision.source = storage::RevisionSource::kImport;
    revision.geometry = {0.05, {1.0, 2.0, 0.0}, 10, 20};
    revision.raster_header = "h";
    for (const char content : {'a', 'b'}) {
      revision.content_sha256 = std::string(32, content);
      revision.tiles = {{{-1, 3}, base_.sha256()}};
      EXPECT_OK(revisions_.Add(Soon(), site_, map_, revision, {base_.view()}));
    }
  }
  storage::StoredPyramid Pyramid() const {
    storage::StoredPyramid pyramid;
    pyramid.lattice_min = {768, -256};
    pyramid.levels = {{{{-1, 3}, base_.sha256()}}, {{{-1, 1}, top_.sha256()}}};
    pyramid.thumbnail = {2, {192, -64}, 2, 3, {0, 1, 2, 2, 1, 0}};
    return pyramid;
  }

  const TestBlob base_{"zoom 0"};
  const TestBlob top_{"zoom 1"};
  storage::PyramidStore pyramids_{*pool_};
};

TEST_F(PyramidStoreTest, FindsWhatWasAddedAndAddsOnce) {
  ASSERT_OK_AND_ASSIGN(const auto none, pyramids_.Find(Soon(), site_, map_, 1));
  EXPECT_FALSE(none.has_value());
  ASSERT_OK_AND_ASSIGN(const auto tiles, pyramids_.ListTiles(Soon(), site_, map_, 1));
  EXPECT_EQ(tiles, Pyramid().levels[0]);
  ASSERT_OK(pyramids_.Add(Soon(), site_, map_, 1, Pyramid(), {top_.view()}));
  ASSERT_OK(pyramids_.Add(Soon(), site_, map_, 1, Pyramid(), {top_.view()}));
  ASSERT_OK_AND_ASSIGN(const auto found, pyramids_.Find(Soon(), site_, map_, 1));
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->levels, Pyramid().levels);
  EXPECT_EQ(found->lattice_min, Pyramid().lattice_min);
  EXPECT_EQ(found->thumbnail.classes, Pyramid().thumbnail.classes);
  EXPECT_EQ(found->thumbnail.height, 3);
  EXPECT_EQ(pyramids_.FindBefore(Soon(), site_, map_, 2).value_or(-1), 1);
  EXPECT_EQ(pyramids_.FindBefore(Soon(), site_, map_, 1).value_or(-1), 0);
}

TEST_F(PyramidStoreTest, RefusesWhatIsMissing) {
  EXPECT_CODE(pyramids_.Add(Soon(), site_, map_, 1, Pyramid(), {}), absl::StatusCode::kFailedPrecondition);
  EXPECT_CODE(pyramids_.Add(Soon(), site_, map_, 9, Pyramid(), {top_.view()}), absl::StatusCode::kNotFound);
}

TEST_F(PyramidStoreTest, ReadsTilesOfPyramidsOnly) {
  const TestBlob other("a picture of a place");
  ASSERT_OK(blobs_.Put(Soon(), site_, {other.view()}));
  const std::vector<std::string> all = {base_.sha256(), top_.sha256(), other.sha256()};
  ASSERT_OK_AND_ASSIGN(const auto before, pyramids_.ReadTiles(Soon(), site_, all));
  EXPECT_TRUE(before.empty());
  ASSERT_OK(pyramids_.Add(Soon(), site_, map_, 1, Pyramid(), {top_.view()}));
  ASSERT_OK_AND_ASSIGN(const auto tiles, pyramids_.ReadTiles(Soon(), site_, all));
  EXPECT_EQ(tiles.size(), 2U);
  EXPECT_EQ(tiles.at(top_.sha256()), "zoom 1");
}

TEST_F(PyramidStoreTest, KeepsItsBlobsAndGoesWithItsRevision) {
  const storage::Maintenance maintenance(*pool_);
  const auto is_stored = [this](const TestBlob& blob) { return blobs_.Get(Soon(), site_, blob.sha256()).ok(); };
  ASSERT_OK(pyramids_.Add(Soon(), site_, map_, 1, Pyramid(), {top_.view()}));
  database_.Sql("UPDATE enfilade.blobs SET put_time = now() - interval '1 day'");
  ASSERT_OK(maintenance.CollectBlobs(Soon(), std::chrono::seconds(0), 1000));
  EXPECT_TRUE(is_stored(top_));
  database_.Sql("DELETE FROM enfilade.map_layers; DELETE FROM enfilade.map_revisions WHERE revision = 1");
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM enfilade.raster_pyramid_tiles"), "0");
  ASSERT_OK(maintenance.CollectBlobs(Soon(), std::chrono::seconds(0), 1000));
  EXPECT_FALSE(is_stored(top_));
  EXPECT_TRUE(is_stored(base_));  // the other revision has it
}

TEST_F(PyramidStoreTest, ListsMapsWithAndWithoutPictures) {
  ASSERT_OK_AND_ASSIGN(const auto without, pyramids_.ListThumbnails(Soon(), site_, std::nullopt, MapId(), 10));
  ASSERT_EQ(without.size(), 1U);
  EXPECT_EQ(without[0].revision, 2);
  EXPECT_FALSE(without[0].thumbnail.has_value());
  EXPECT_EQ(without[0].geometry.T_map_grid.y, 2.0);
  ASSERT_OK(pyramids_.Add(Soon(), site_, map_, 2, Pyramid(), {top_.view()}));
  ASSERT_OK_AND_ASSIGN(const auto with, pyramids_.ListThumbnails(Soon(), site_, 0, MapId(), 10));
  ASSERT_EQ(with.size(), 1U);
  EXPECT_EQ(with[0].thumbnail.value_or(grid::Thumbnail()).lower_left, (grid::CellIndex{192, -64}));
  EXPECT_EQ(pyramids_.ListThumbnails(Soon(), site_, 3, MapId(), 10)->size(), 0U);
  EXPECT_EQ(pyramids_.ListThumbnails(Soon(), site_, 0, map_, 10)->size(), 0U);
  EXPECT_CODE(pyramids_.ListThumbnails(Soon(), SiteId("nowhere"), 0, MapId(), 10), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace enfilade::testing
