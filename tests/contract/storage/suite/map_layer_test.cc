// SPDX-License-Identifier: Apache-2.0
#include "core/base/sha256.h"
#include "storage/maps/revision_store.h"
#include "tests/contract/storage/suite/contract_test.h"

namespace enfilade::testing {
namespace {

using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class MapLayerTest : public StoreContractTest {
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
  static std::vector<std::string> DigestsOf(const storage::MapLayer& layer) {
    std::vector<std::string> digests;
    for (const storage::TileRef& tile : layer.raster.tiles) digests.push_back(tile.sha256);
    return digests;
  }
  // As a mapping worker that renders `session`.
  storage::LayersBeside WithRuns(const std::string& session, double resolution = 0.05) {
    const auto layers = revisions_.ReadRunsBeside(Soon(), site_, map_, SessionId(session), resolution);
    EXPECT_OK(layers);
    return *layers;
  }
  // Sessions s1 to s4, each with the layer that it is named after, one above the other.
  void AddFourLayers() {
    NewSession("s3");
    NewSession("s4");
    for (const std::string name : {"s1", "s2", "s3", "s4"}) ASSERT_OK(Add(RevisionOf(SessionId(name), {name})));
  }
  storage::NewLayerRun RunOf(std::int64_t first, std::int64_t last) {
    storage::NewLayerRun run;
    run.first = first;
    run.last = last;
    run.resolution = 0.05;
    run.layers_version = Beside("none").version;
    run.reset = RasterOf({"reset"});
    run.content = RasterOf({"content", "more"});
    return run;
  }
  absl::Status AddRun(const storage::NewLayerRun& run) { return revisions_.AddRun(Soon(), site_, map_, run); }
  absl::Status Merge(const storage::NewLayerRun& merged) { return revisions_.MergeLayers(Soon(), site_, map_, merged); }
  std::vector<storage::MapLayer> Orphaned(int least, int limit = 100) {
    const auto orphaned = revisions_.ReadOrphanedLayers(Soon(), site_, map_, least, limit);
    EXPECT_OK(orphaned);
    if (!orphaned->layers.empty()) {
      EXPECT_EQ(orphaned->version, Beside("none").version);
    }
    return orphaned->layers;
  }
  // The first tile of each layer; runs in brackets.
  static std::string Drawn(const storage::LayersBeside& beside) {
    std::string text;
    const auto add = [&](const std::vector<storage::MapLayer>& layers) {
      for (const storage::MapLayer& layer : layers) {
        for (const std::string name : {"s1", "s2", "s3", "s4", "reset", "content", "import"}) {
          if (layer.raster.tiles.at(0).sha256 != DigestOf(name)) continue;
          text += layer.is_run() ? "[" + name + "] " : name + " ";
        }
      }
    };
    add(beside.below);
    text += "| ";
    add(beside.above);
    return text;
  }
  static std::string DigestOf(const std::string& content) { return TestBlob(content).sha256(); }

  const SessionId first_ = NewSession("s1");
  const SessionId second_ = NewSession("s2");
};

TEST_F(MapLayerTest, TheLayerOfOneSessionIsItsRevision) {
  ASSERT_OK(Add(RevisionOf(first_, {"a", "b"})));
  ASSERT_OK(Add(RevisionOf(first_, {"a", "c"})));
  EXPECT_THAT(Beside("s1").below, IsEmpty());
  const storage::LayersBeside seen = Beside("s2");
  ASSERT_THAT(seen.below, SizeIs(1));
  EXPECT_EQ(seen.below[0].session, first_);
  EXPECT_EQ(seen.below[0].raster.header, "header");
  EXPECT_THAT(DigestsOf(seen.below[0]), ElementsAre(DigestOf("a"), DigestOf("c")));
}

TEST_F(MapLayerTest, LayersLieInTheOrderInWhichSessionsCame) {
  ASSERT_OK(Add(RevisionOf(first_, {"a"})));
  storage::NewRevision both = RevisionOf(second_, {"ab", "b"});
  both.layer = RasterOf({"b1", "b2", "b3"});
  both.layers_version = Beside("s2").version;
  ASSERT_OK(Add(both));
  ASSERT_THAT(Beside("s1").above, SizeIs(1));
  EXPECT_THAT(DigestsOf(Beside("s1").above[0]), ElementsAre(DigestOf("b1"), DigestOf("b2"), DigestOf("b3")));
  // Rendered anew: one tile stays, one changes, one goes.
  both.layer = RasterOf({"b1", "b4"});
  both.layers_version = Beside("s2").version;
  ASSERT_OK(Add(both));
  EXPECT_THAT(DigestsOf(Beside("s1").above[0]), ElementsAre(DigestOf("b1"), DigestOf("b4")));
  // The first one's next layer stays below.
  storage::NewRevision again = RevisionOf(first_, {"a2b", "b"});
  again.layer = RasterOf({"a2"});
  ASSERT_OK(Add(again));
  EXPECT_THAT(Beside("s2").below, SizeIs(1));
  EXPECT_THAT(Beside("s2").above, IsEmpty());
  EXPECT_THAT(DigestsOf(Beside("s2").below[0]), ElementsAre(DigestOf("a2")));
}

TEST_F(MapLayerTest, WhatWasLaidTogetherFromOldLayersIsRefusedWhole) {
  const std::int64_t version = Beside("s2").version;
  ASSERT_OK(Add(RevisionOf(first_, {"a"})));
  storage::NewRevision stale = RevisionOf(second_, {"b"});
  stale.layers_version = version;
  const absl::Status refused = Add(stale);
  EXPECT_CODE(refused, absl::StatusCode::kAborted);
  EXPECT_TRUE(storage::AreLayersChanged(refused));
  EXPECT_EQ(backend_->CountRevisions(), 1);
  EXPECT_THAT(Beside("s1").above, IsEmpty());
  stale.layers_version = Beside("s2").version;
  EXPECT_OK(Add(stale));
  EXPECT_FALSE(storage::AreLayersChanged(absl::AbortedError("another reason")));
}

TEST_F(MapLayerTest, AnImportTakesTheirPlaceAndSessionsGoOnAboveIt) {
  ASSERT_OK(Add(RevisionOf(first_, {"a"})));
  ASSERT_OK(Add(RevisionOf(std::nullopt, {"edited"})));
  const storage::LayersBeside seen = Beside("s1");
  EXPECT_THAT(seen.above, IsEmpty());
  ASSERT_THAT(seen.below, SizeIs(1));
  EXPECT_EQ(seen.below[0].session, std::nullopt);
  EXPECT_THAT(DigestsOf(seen.below[0]), ElementsAre(DigestOf("edited")));
  storage::NewRevision next = RevisionOf(first_, {"a on edited"});
  next.layer = RasterOf({"a"});
  next.layers_version = seen.version;
  ASSERT_OK(Add(next));
  EXPECT_THAT(Beside("s2").below, SizeIs(2));
}

TEST_F(MapLayerTest, ARestoredRevisionTakesTheirPlaceAndAnEditDoesNot) {
  ASSERT_OK(Add(RevisionOf(first_, {"a"})));
  storage::NewRevision edit = RevisionOf(std::nullopt, {"edited"});
  edit.source = storage::RevisionSource::kEdit;
  ASSERT_OK(Add(edit));
  EXPECT_THAT(DigestsOf(Beside("none").below.at(0)), ElementsAre(DigestOf("a")));
  storage::NewRevision restored = RevisionOf(std::nullopt, {"older"});
  restored.source = storage::RevisionSource::kRestored;
  ASSERT_OK(Add(restored));
  const storage::LayersBeside seen = Beside("s1");
  EXPECT_THAT(seen.above, IsEmpty());
  ASSERT_THAT(seen.below, SizeIs(1));
  EXPECT_THAT(DigestsOf(seen.below[0]), ElementsAre(DigestOf("older")));
}

TEST_F(MapLayerTest, ARunStandsForItsLayers) {
  ASSERT_NO_FATAL_FAILURE(AddFourLayers());
  const std::vector<storage::MapLayer> layers = Beside("none").below;
  ASSERT_THAT(layers, SizeIs(4));
  const std::int64_t version = Beside("none").version;
  ASSERT_OK(AddRun(RunOf(layers[1].first, layers[2].last)));
  EXPECT_EQ(Drawn(WithRuns("none")), "s1 [reset] [content] s4 | ");
  EXPECT_EQ(Drawn(Beside("none")), "s1 s2 s3 s4 | ") << "the layers stay";
  EXPECT_EQ(Beside("none").version, version);
  EXPECT_EQ(WithRuns("none").version, version);
  const storage::MapLayer content = WithRuns("none").below[2];
  EXPECT_EQ(content.first, layers[1].first);
  EXPECT_EQ(content.last, layers[2].last);
  EXPECT_THAT(DigestsOf(content), ElementsAre(DigestOf("content"), DigestOf("more")));
  EXPECT_EQ(Drawn(WithRuns("s1")), "| [reset] [content] s4 ");
  EXPECT_EQ(Drawn(WithRuns("s4")), "s1 [reset] [content] | ");
  EXPECT_EQ(Drawn(WithRuns("s3")), "s1 s2 | s4 ") << "it is in the run";
  EXPECT_EQ(Drawn(WithRuns("none", 0.1)), "s1 s2 s3 s4 | ") << "the run is for other cells";
}

TEST_F(MapLayerTest, LayersSayWhenTheyLastChanged) {
  ASSERT_NO_FATAL_FAILURE(AddFourLayers());
  const storage::LayersBeside before = Beside("none");
  ASSERT_OK(Add(RevisionOf(first_, {"anew"})));
  const storage::LayersBeside after = Beside("none");
  EXPECT_GT(after.version, before.version);
  EXPECT_EQ(after.below[0].version, after.version);
  EXPECT_EQ(after.below[3].version, before.version);
  EXPECT_EQ(after.below[2].version, before.below[2].version);
  EXPECT_LT(after.below[2].version, before.version);
}

TEST_F(MapLayerTest, ALongerRunTakesThePlaceOfAShorterOne) {
  ASSERT_NO_FATAL_FAILURE(AddFourLayers());
  const std::vector<storage::MapLayer> layers = Beside("none").below;
  ASSERT_OK(AddRun(RunOf(layers[0].first, layers[1].last)));
  ASSERT_OK(AddRun(RunOf(layers[2].first, layers[3].last)));
  EXPECT_EQ(Drawn(WithRuns("none")), "[reset] [content] [reset] [content] | ");
  storage::NewLayerRun whole = RunOf(layers[0].first, layers[3].last);
  whole.reset.reset();
  ASSERT_OK(AddRun(whole));
  EXPECT_EQ(Drawn(WithRuns("none")), "[content] | ");
}

TEST_F(MapLayerTest, ARunIsForgottenWhenOneOfItsLayersChanges) {
  ASSERT_NO_FATAL_FAILURE(AddFourLayers());
  const std::vector<storage::MapLayer> layers = Beside("none").below;
  ASSERT_OK(AddRun(RunOf(layers[0].first, layers[1].last)));
  ASSERT_OK(AddRun(RunOf(layers[2].first, layers[3].last)));
  ASSERT_OK(Add(RevisionOf(second_, {"s2"})));
  EXPECT_EQ(Drawn(WithRuns("none")), "s1 s2 [reset] [content] | ");
  ASSERT_OK(Add(RevisionOf(std::nullopt, {"import"})));
  EXPECT_EQ(Drawn(WithRuns("none")), "import | ") << "it replaces all layers";
}

TEST_F(MapLayerTest, ARunOfOldLayersIsRefused) {
  ASSERT_NO_FATAL_FAILURE(AddFourLayers());
  const std::vector<storage::MapLayer> layers = Beside("none").below;
  const storage::NewLayerRun run = RunOf(layers[0].first, layers[3].last);
  ASSERT_OK(Add(RevisionOf(second_, {"s2 anew"})));
  EXPECT_TRUE(storage::AreLayersChanged(AddRun(run)));
  EXPECT_THAT(WithRuns("none").below, SizeIs(4));
  storage::NewLayerRun missing = RunOf(layers[0].first, layers[3].last);
  missing.content.tiles.push_back({{7, 7}, Sha256("never put")});
  EXPECT_CODE(AddRun(missing), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(WithRuns("none").below, SizeIs(4));
  EXPECT_TRUE(storage::AreLayersChanged(revisions_.AddRun(Soon(), site_, MapId("nowhere"), run)));
}

TEST_F(MapLayerTest, LayersOfDeletedSessionsAreMergedForGood) {
  ASSERT_NO_FATAL_FAILURE(AddFourLayers());
  EXPECT_THAT(Orphaned(1), IsEmpty());
  for (const char* id : {"s2", "s3"}) ASSERT_OK(sessions_.Delete(Soon(), site_, SessionId(id)));
  EXPECT_THAT(Orphaned(3), IsEmpty()) << "too few";
  const std::vector<storage::MapLayer> orphaned = Orphaned(2);
  ASSERT_THAT(orphaned, SizeIs(2));
  EXPECT_EQ(orphaned[0].session, second_);
  EXPECT_EQ(orphaned[0].raster.header, "header");
  EXPECT_THAT(DigestsOf(orphaned[0]), ElementsAre(DigestOf("s2")));
  EXPECT_THAT(Orphaned(2, 1), SizeIs(1));
  const std::int64_t version = Beside("none").version;
  storage::NewLayerRun merged = RunOf(orphaned[0].first, orphaned[1].last);
  ASSERT_OK(Merge(merged));
  EXPECT_EQ(Drawn(Beside("none")), "s1 reset content s4 | ");
  EXPECT_EQ(Drawn(Beside("s4")), "s1 reset content | ");
  EXPECT_GT(Beside("none").version, version);
  EXPECT_THAT(DigestsOf(Beside("none").below[2]), ElementsAre(DigestOf("content"), DigestOf("more")));
  EXPECT_TRUE(storage::AreLayersChanged(Merge(merged))) << "of layers that are gone";
  // With the next sessions that are deleted, they are merged again.
  EXPECT_THAT(Orphaned(1), IsEmpty());
  ASSERT_OK(sessions_.Delete(Soon(), site_, SessionId("s4")));
  const std::vector<storage::MapLayer> next = Orphaned(1);
  ASSERT_THAT(next, SizeIs(3));
  merged = RunOf(next[0].first, next[2].last);
  merged.reset.reset();
  ASSERT_OK(Merge(merged));
  EXPECT_EQ(Drawn(Beside("none")), "s1 content | ");
}

TEST_F(MapLayerTest, AnImportIsNotMerged) {
  ASSERT_OK(Add(RevisionOf(std::nullopt, {"import"})));
  storage::NewRevision above = RevisionOf(first_, {"on import"});
  above.layer = RasterOf({"s1"});
  ASSERT_OK(Add(above));
  ASSERT_OK(sessions_.Delete(Soon(), site_, first_));
  ASSERT_THAT(Orphaned(1), SizeIs(1));
  EXPECT_EQ(Orphaned(1)[0].session, first_);
}

TEST_F(MapLayerTest, MergingForgetsRunsOfSomeOfTheLayersOnly) {
  ASSERT_NO_FATAL_FAILURE(AddFourLayers());
  const std::vector<storage::MapLayer> layers = Beside("none").below;
  ASSERT_OK(AddRun(RunOf(layers[0].first, layers[3].last)));
  storage::NewLayerRun merged = RunOf(layers[1].first, layers[2].last);
  ASSERT_OK(Merge(merged));
  EXPECT_EQ(Drawn(WithRuns("none")), "[reset] [content] | ") << "a run of all of them, and of others, is what it was";
  ASSERT_OK(AddRun(RunOf(layers[2].first, layers[3].last)));
  merged = RunOf(layers[0].first, layers[2].last);
  ASSERT_OK(Merge(merged));
  EXPECT_EQ(Drawn(WithRuns("none")), "reset content s4 | ");
}

}  // namespace
}  // namespace enfilade::testing
