// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "core/base/sha256.h"
#include "storage/sites/maintenance.h"
#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

using std::chrono::seconds;
using ::testing::SizeIs;

// How the layers of a map are stored: the rest is in suite/map_layer_test.cc.
class MapLayerRowsTest : public StoreTest {
 protected:
  // A raster of one row of tiles, each of the content named.
  storage::StoredRaster RasterOf(const std::vector<std::string>& contents) {
    storage::StoredRaster raster{"header", {}};
    for (const std::string& content : contents) {
      const TestBlob blob(content);
      EXPECT_OK(blobs_.Put(Soon(), site_, std::vector<storage::BlobView>{blob.view()}));
      raster.tiles.push_back({{0, static_cast<int>(raster.tiles.size())}, blob.sha256()});
    }
    return raster;
  }
  storage::NewRevision RevisionOf(const std::optional<SessionId>& session, const std::vector<std::string>& contents) {
    storage::NewRevision revision;
    revision.source = session ? storage::RevisionSource::kMapping : storage::RevisionSource::kImport;
    revision.session = session;
    revision.geometry = {0.05, {}, 256 * static_cast<int>(contents.size()), 256};
    const storage::StoredRaster raster = RasterOf(contents);
    revision.raster_header = raster.header;
    revision.tiles = raster.tiles;
    for (const std::string& content : contents) revision.content_sha256 += content;
    revision.content_sha256 = Sha256(revision.content_sha256);
    return revision;
  }
  absl::Status Add(const storage::NewRevision& revision) {
    return revisions_.Add(Soon(), site_, map_, revision, {}).status();
  }
  storage::LayersBeside Beside(const std::string& session) {
    const auto layers = revisions_.ReadLayersBeside(Soon(), site_, map_, SessionId(session));
    EXPECT_OK(layers);
    return *layers;
  }

  const SessionId first_ = NewSession("s1");
  const SessionId second_ = NewSession("s2");
};

TEST_F(MapLayerRowsTest, OneSessionAloneStoresItsTilesOnce) {
  ASSERT_OK(Add(RevisionOf(first_, {"a", "b"})));
  ASSERT_OK(Add(RevisionOf(first_, {"a", "c"})));
  ASSERT_THAT(Beside("s2").below, SizeIs(1));
  EXPECT_THAT(Beside("s2").below[0].raster.tiles, SizeIs(2));
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM enfilade.map_layer_tiles"), "0");
}

TEST_F(MapLayerRowsTest, TilesOfLayersAreKeptAsLongAsTheMap) {
  ASSERT_OK(Add(RevisionOf(first_, {"a"})));
  storage::NewRevision both = RevisionOf(second_, {"ab"});
  both.layer = RasterOf({"only in the layer"});
  ASSERT_OK(Add(both));
  RasterOf({"nobody's"});
  storage::Maintenance maintenance(*pool_);
  ASSERT_OK_AND_ASSIGN(const storage::MaintenancePortion collected, maintenance.CollectBlobs(Soon(), seconds(0), 1000));
  EXPECT_EQ(collected.deleted, 1);
  ASSERT_OK(sessions_.Delete(Soon(), site_, second_));
  EXPECT_THAT(Beside("s1").above, SizeIs(1)) << "what a deleted session has seen stays in the map";
  ASSERT_OK(maps_.Delete(Soon(), site_, map_, 0, true));
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM enfilade.map_layers"), "0");
  ASSERT_OK_AND_ASSIGN(const storage::MaintenancePortion rest, maintenance.CollectBlobs(Soon(), seconds(0), 1000));
  EXPECT_EQ(rest.deleted, 3);
}

}  // namespace
}  // namespace enfilade::testing
