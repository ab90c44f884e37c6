// SPDX-License-Identifier: Apache-2.0
#include "server/app/mapping/layer_runs.h"

#include <random>

#include "server/app/mapping/layer_overlay.h"
#include "server/app/mapping/raster_revision.h"
#include "tests/unit/server/app/forwarding_revision_store.h"
#include "tests/unit/server/app/mapping/mapping_fixture.h"

namespace enfilade::server {
namespace {

using Progress = SessionMapping::Progress;

constexpr double kCell = 0.05;

// Counts the layers and the tiles that are read.
class CountingRevisions final : public ForwardingRevisionStore {
 public:
  using ForwardingRevisionStore::ForwardingRevisionStore;

  absl::StatusOr<storage::LayersBeside> ReadLayersBeside(const storage::CallContext& context, const SiteId& site,
                                                         const MapId& map, const SessionId& session) const override {
    return Counted(ForwardingRevisionStore::ReadLayersBeside(context, site, map, session));
  }
  absl::StatusOr<storage::LayersBeside> ReadRunsBeside(const storage::CallContext& context, const SiteId& site,
                                                       const MapId& map, const SessionId& session,
                                                       double resolution) const override {
    return Counted(ForwardingRevisionStore::ReadRunsBeside(context, site, map, session, resolution));
  }
  int TakeLayersRead() { return std::exchange(layers_read_, 0); }

 private:
  absl::StatusOr<storage::LayersBeside> Counted(absl::StatusOr<storage::LayersBeside> beside) const {
    if (beside.ok()) layers_read_ += static_cast<int>(beside->below.size() + beside->above.size());
    return beside;
  }

  mutable int layers_read_ = 0;
};

class CountingBlobs final : public storage::BlobStore {
 public:
  explicit CountingBlobs(const storage::BlobStore& store) : store_(store) {}
  absl::Status Put(const storage::CallContext& context, const SiteId& site,
                   absl::Span<const storage::BlobView> blobs) const override {
    return store_.Put(context, site, blobs);
  }
  absl::StatusOr<std::string> Get(const storage::CallContext& context, const SiteId& site,
                                  std::string_view sha256) const override {
    ++reads_;
    return store_.Get(context, site, sha256);
  }
  int TakeReads() { return std::exchange(reads_, 0); }

 private:
  const storage::BlobStore& store_;
  mutable int reads_ = 0;
};

// Runs are never made.
class WithoutRuns final : public ForwardingRevisionStore {
 public:
  using ForwardingRevisionStore::ForwardingRevisionStore;
  absl::StatusOr<storage::LayersBeside> ReadRunsBeside(const storage::CallContext& context, const SiteId& site,
                                                       const MapId& map, const SessionId& session,
                                                       double /*resolution*/) const override {
    return ForwardingRevisionStore::ReadLayersBeside(context, site, map, session);
  }
  absl::Status AddRun(const storage::CallContext&, const SiteId& site, const MapId& map,
                      const storage::NewLayerRun&) const override {
    return storage::LayersChanged(site, map);
  }
};

class LayerRunsTest : public MappingFixture {
 protected:
  // What a session has seen: cells that are free, occupied, or unknown.
  grid::OccupancyGrid SeenBy(unsigned seed) const {
    std::minstd_rand random(seed + 1);
    grid::OccupancyGrid grid;
    grid.geometry = {.resolution = kCell,
                     .T_map_grid = {static_cast<int>(random() % 9) * kCell, 0.0, 0.0},
                     .width = 30 + static_cast<int>(random() % 30),
                     .height = 40};
    for (std::size_t i = 0; i < grid.geometry.cell_count(); ++i) {
      grid.cells.push_back(random() % 3 == 0 ? grid::kUnknownCell : static_cast<std::uint8_t>(1 + random() % 255));
    }
    return grid;
  }
  // A session that was mapped long ago into the map.
  void AddOldLayer(int i) {
    const SessionId session("old" + std::to_string(i));
    RasterRevision raster = *ToRevision(grid::FromOccupancyGrid(SeenBy(static_cast<unsigned>(i))));
    ASSERT_OK(PutTiles(Soon(), stores_.blobs, site_, raster, {}));
    raster.revision.source = storage::RevisionSource::kMapping;
    raster.revision.session = session;
    ASSERT_OK(stores_.revisions.Add(Soon(), site_, map_, raster.revision, {}));
  }
  SessionMappingStores StoresWith(const storage::RevisionStore& revisions, const storage::BlobStore& blobs) const {
    return {stores_.mappings, stores_.records, stores_.sessions, blobs, revisions, stores_.robot_poses, stores_.maps};
  }
  // A session that began in the map when it was empty, and is to be mapped.
  struct Waiting {
    storage::LeasedSession leased;
    std::unique_ptr<SessionMapping> mapping;
  };
  Waiting Begin(const std::string& id, const SessionMappingStores& stores) {
    const SessionId session = NewSession(id, map_.value());
    Append(session, 0, 40);
    Finish(session);
    Waiting waiting;
    waiting.leased = **stores_.mappings.Acquire(Soon(), "worker", std::chrono::seconds(600));
    EXPECT_EQ(waiting.leased.session.id, session);
    waiting.mapping = *SessionMapping::Load(stores, {}, waiting.leased.session);
    return waiting;
  }
  static void MapToItsEnd(Waiting& waiting) {
    while (true) {
      const auto progress = waiting.mapping->Step(waiting.leased.lease);
      ASSERT_OK(progress);
      if (*progress != Progress::kWorked) break;
    }
    EXPECT_TRUE(waiting.mapping->ended());
  }
  storage::MapRevision CurrentRevision() { return *stores_.revisions.Get(Soon(), site_, map_, 0); }

  MapId map_ = hall_;
};

struct LayersRead {
  int layers = 0;
  int tiles = 0;
};

TEST_F(LayerRunsTest, ARevisionReadsTheSameAfterTenAndAfterThreeHundredSessions) {
  CountingRevisions revisions(stores_.revisions);
  CountingBlobs blobs(stores_.blobs);
  // The most that any of twenty sessions in succession reads, each of which stores one revision, after as many others.
  const auto most_read_after = [&](int old_sessions) {
    std::vector<Waiting> sessions;
    for (int i = 0; i < 40; ++i) {
      sessions.push_back(Begin(map_.value() + std::to_string(i), StoresWith(revisions, blobs)));
    }
    for (int i = 0; i < old_sessions; ++i) AddOldLayer(i);
    LayersRead most;
    for (int i = 0; i < 40; ++i) {
      if (i == 20) most = {};
      revisions.TakeLayersRead();
      blobs.TakeReads();
      MapToItsEnd(sessions[static_cast<std::size_t>(i)]);
      most.layers = std::max(most.layers, revisions.TakeLayersRead());
      most.tiles = std::max(most.tiles, blobs.TakeReads());
    }
    EXPECT_EQ(CurrentRevision().session, SessionId(map_.value() + "39"));
    return most;
  };
  const LayersRead after_ten = most_read_after(10);
  ASSERT_OK(stores_.maps.Create(Soon(), MakeMap(site_, "annex"), ""));
  map_ = MapId("annex");
  const LayersRead after_many = most_read_after(300);
  EXPECT_EQ(after_many.layers, after_ten.layers);
  EXPECT_EQ(after_many.tiles, after_ten.tiles);
}

TEST_F(LayerRunsTest, RevisionsAreTheSameAsWithoutThem) {
  const WithoutRuns without(stores_.revisions);
  Waiting plain = Begin("plain", StoresWith(without, stores_.blobs));
  Waiting with_runs = Begin("with-runs", mapping_stores());
  for (int i = 0; i < 100; ++i) ASSERT_NO_FATAL_FAILURE(AddOldLayer(i));
  ASSERT_NO_FATAL_FAILURE(MapToItsEnd(plain));
  const storage::MapRevision expected = CurrentRevision();
  ASSERT_EQ(expected.session, SessionId("plain"));
  ASSERT_NO_FATAL_FAILURE(MapToItsEnd(with_runs));
  const storage::MapRevision revision = CurrentRevision();
  ASSERT_EQ(revision.session, SessionId("with-runs"));
  // Both sessions have the same records, so that the second one's layer changes nothing.
  EXPECT_EQ(revision.content_sha256, expected.content_sha256);
  const auto seen = stores_.revisions.ReadRunsBeside(Soon(), site_, map_, SessionId(), kCell);
  ASSERT_OK(seen);
  EXPECT_TRUE(seen->below.front().is_run());
  EXPECT_LT(seen->below.size(), 20U);
}

TEST_F(LayerRunsTest, ASessionAmongOldLayersIsTakenOutOfItsRun) {
  for (int i = 0; i < 40; ++i) ASSERT_NO_FATAL_FAILURE(AddOldLayer(i));
  const SessionId changed("old5");
  const auto compose = [&](const storage::LayersBeside& beside) {
    LayerOverlay overlay(stores_.blobs, site_);
    return *overlay.Compose(Soon(), beside, SeenBy(1000));
  };
  const LayerRuns runs(stores_.blobs, stores_.revisions, site_, map_);
  storage::LayersBeside top = *stores_.revisions.ReadRunsBeside(Soon(), site_, map_, SessionId(), kCell);
  ASSERT_TRUE(*runs.MakeNext(Soon(), kCell, top));
  EXPECT_EQ(compose(top), compose(*stores_.revisions.ReadLayersBeside(Soon(), site_, map_, SessionId())));
  // Its own layer is within the run: the run does not count for it.
  storage::LayersBeside among = *stores_.revisions.ReadRunsBeside(Soon(), site_, map_, changed, kCell);
  EXPECT_EQ(among.below.size() + among.above.size(), 39U);
  ASSERT_TRUE(*runs.MakeNext(Soon(), kCell, among)) << "those above it";
  EXPECT_EQ(compose(among), compose(*stores_.revisions.ReadLayersBeside(Soon(), site_, map_, changed)));
  EXPECT_LT(among.above.size(), 12U);
}

TEST_F(LayerRunsTest, LayersOfDeletedSessionsAreMergedAndRevisionsStayTheSame) {
  for (int i = 0; i < 30; ++i) {
    NewSession("old" + std::to_string(i), map_.value());
    ASSERT_NO_FATAL_FAILURE(AddOldLayer(i));
  }
  const auto compose = [&] {
    LayerOverlay overlay(stores_.blobs, site_);
    return *overlay.Compose(Soon(), *stores_.revisions.ReadLayersBeside(Soon(), site_, map_, SessionId()),
                            SeenBy(1000));
  };
  const auto count_layers = [&] {
    return stores_.revisions.ReadLayersBeside(Soon(), site_, map_, SessionId())->below.size();
  };
  const grid::OccupancyGrid expected = compose();
  const LayerRuns runs(stores_.blobs, stores_.revisions, site_, map_);
  EXPECT_FALSE(*runs.MergeOrphaned(Soon()));
  // All but the layers at 5 and 20.
  for (int i = 0; i < 30; ++i) {
    if (i == 5 || i == 20) continue;
    ASSERT_OK(stores_.sessions.Delete(Soon(), site_, SessionId("old" + std::to_string(i))));
  }
  ASSERT_TRUE(*runs.MergeOrphaned(Soon())) << "6 to 19: below there are too few";
  EXPECT_EQ(count_layers(), 30U - 14U + 2U);
  ASSERT_TRUE(*runs.MergeOrphaned(Soon())) << "21 to 29";
  EXPECT_EQ(count_layers(), 30U - 14U + 2U - 9U + 2U);
  EXPECT_FALSE(*runs.MergeOrphaned(Soon()));
  EXPECT_EQ(compose(), expected);
  ASSERT_OK(stores_.sessions.Delete(Soon(), site_, SessionId("old5")));
  EXPECT_FALSE(*runs.MergeOrphaned(Soon())) << "only six are deleted since, beside what was merged";
  EXPECT_EQ(compose(), expected);
}

TEST_F(LayerRunsTest, ASessionThatIsMappedMergesTheLayersOfDeletedOnes) {
  Waiting next = Begin("next", mapping_stores());
  for (int i = 0; i < 12; ++i) {
    NewSession("old" + std::to_string(i), map_.value());
    ASSERT_NO_FATAL_FAILURE(AddOldLayer(i));
    ASSERT_OK(stores_.sessions.Delete(Soon(), site_, SessionId("old" + std::to_string(i))));
  }
  ASSERT_NO_FATAL_FAILURE(MapToItsEnd(next));
  EXPECT_EQ(stores_.revisions.ReadLayersBeside(Soon(), site_, map_, SessionId())->below.size(), 3U);
}

TEST(SelectRun, TakesNeighboursThatHaveNotChangedForAWhile) {
  const auto layers = [](std::vector<std::int64_t> versions) {
    std::vector<storage::MapLayer> result;
    for (std::int64_t version : versions) {
      const auto place = static_cast<std::int64_t>(result.size()) + 1;
      result.push_back({std::nullopt, {}, place, place, version});
    }
    return result;
  };
  const auto span = [](std::size_t begin, std::size_t end) {
    return [=](const std::optional<LayerSpan>& found) { return found && found->begin == begin && found->end == end; };
  };
  EXPECT_FALSE(SelectRun(layers({1, 2, 3, 4, 5, 6, 7}), 100)) << "too few";
  EXPECT_PRED1(span(0, 8), SelectRun(layers({1, 2, 3, 4, 5, 6, 7, 8, 93}), 100));
  EXPECT_PRED1(span(2, 9), SelectRun(layers({1, 99, 2, 3, 4, 5, 6, 7, 8}), 100)) << "one alone is no run";
  EXPECT_FALSE(SelectRun(layers({1, 99, 2, 98, 3, 97, 4, 96, 5, 95, 6, 94, 7, 93, 8, 93, 9}), 100));
  std::vector<storage::MapLayer> many = layers(std::vector<std::int64_t>(200, 1));
  EXPECT_PRED1(span(0, 64), SelectRun(many, 100));
  // A run is two layers of the same places.
  many[63].first = many[64].first = 64;
  many[63].last = many[64].last = 65;
  EXPECT_PRED1(span(0, 65), SelectRun(many, 100));
}

}  // namespace
}  // namespace enfilade::server
