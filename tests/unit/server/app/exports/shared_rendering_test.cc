// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <atomic>
#include <future>
#include <latch>
#include <memory>
#include <stop_token>
#include <vector>

#include "server/app/exports/map_exports.h"
#include "server/app/mapping/raster_revision.h"
#include "tests/fakes/in_memory_stores.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"
#include "tests/unit/server/app/forwarding_revision_store.h"
#include "tests/unit/server/app/test_values.h"

namespace enfilade::server {
namespace {

using ::testing::Each;

// Counts the rasters that are read, and holds up the first read until a test lets it go on.
class HeldRevisions final : public ForwardingRevisionStore {
 public:
  explicit HeldRevisions(const storage::RevisionStore& store) : ForwardingRevisionStore(store) {}
  ~HeldRevisions() override { GoOn(); }

  int rasters_read() const { return rasters_read_; }
  void AwaitReading() { reading_.wait(); }
  void GoOn() {
    if (!gone_on_.exchange(true)) go_on_.count_down();
  }

  absl::StatusOr<std::vector<storage::Tile>> ReadTiles(const storage::CallContext& context,
                                                       const storage::MapRevision& revision,
                                                       std::optional<storage::TileKey> after,
                                                       std::int64_t max_bytes) const override {
    if (!after && rasters_read_++ == 0) {
      reading_.count_down();
      go_on_.wait();
    }
    if (context.cancellation.stop_requested()) return absl::CancelledError("cancelled in the database");
    return ForwardingRevisionStore::ReadTiles(context, revision, after, max_bytes);
  }

 private:
  mutable std::atomic<int> rasters_read_ = 0;
  std::atomic<bool> gone_on_ = false;
  mutable std::latch reading_{1};
  mutable std::latch go_on_{1};
};

class SharedRenderingTest : public ::testing::Test {
 protected:
  using Future = std::future<absl::StatusOr<ExportedMap>>;

  SharedRenderingTest() {
    stores_.database.AddSite(site_);
    options_.cache_directory = directory_.path();
    Import("hall", 40, 30);
    auto exports = MapExports::Create(options_, stores_.maps, {stores_.blobs, revisions_});
    EXPECT_OK(exports);
    exports_ = *std::move(exports);
  }

  void Import(const std::string& map, int width, int height) {
    EXPECT_OK(stores_.maps.Create(Soon(), MakeMap(site_, map), ""));
    grid::OccupancyGrid grid;
    grid.geometry.width = width;
    grid.geometry.height = height;
    grid.geometry.resolution = 0.05;
    grid.cells.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 1);
    auto raster = ToRevision(grid::FromOccupancyGrid(grid));
    ASSERT_OK(raster);
    ASSERT_OK(PutTiles(Soon(), stores_.blobs, site_, *raster, {}));
    raster->revision.source = storage::RevisionSource::kImport;
    ASSERT_OK(stores_.revisions.Add(Soon(), site_, MapId(map), raster->revision, {}));
  }
  Future Export(const std::string& map, const std::stop_source& client = {}) {
    const auto exported = std::make_shared<std::promise<absl::StatusOr<ExportedMap>>>();
    storage::CallContext context = Soon();
    context.cancellation = client.get_token();
    exports_->Get(context, {{site_, MapId(map), 0}, grid::MapFileFormat::kPgm},
                  [exported](absl::StatusOr<ExportedMap> given) { exported->set_value(std::move(given)); });
    return exported->get_future();
  }
  static bool IsReady(const Future& future) {
    return future.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  }

  const SiteId site_{"campus"};
  testing::InMemoryStores stores_;
  HeldRevisions revisions_{stores_.revisions};
  const testing::TemporaryDirectory directory_;
  ServerOptions::Transfers options_;
  std::unique_ptr<MapExports> exports_;
};

TEST_F(SharedRenderingTest, ManyWhoWantOneMapWaitForOneRenderingAndHoldNoThread) {
  std::vector<Future> exported;
  for (int i = 0; i < 9; ++i) exported.push_back(Export("hall"));  // one thread: none of them waits
  revisions_.AwaitReading();
  for (const Future& future : exported) EXPECT_FALSE(IsReady(future));
  revisions_.GoOn();
  std::vector<const void*> contents;
  for (Future& future : exported) {
    const absl::StatusOr<ExportedMap> map = future.get();
    ASSERT_OK(map);
    contents.push_back(map->files[0].content.get());
  }
  EXPECT_THAT(contents, Each(contents[0]));
  EXPECT_EQ(revisions_.rasters_read(), 1);
  Future again = Export("hall");
  EXPECT_TRUE(IsReady(again)) << "from the cache";
}

TEST_F(SharedRenderingTest, ASmallMapDoesNotWaitForALargeOne) {
  Import("campus", 4100, 4100);
  Future large = Export("campus");
  revisions_.AwaitReading();
  EXPECT_OK(Export("hall").get());
  EXPECT_FALSE(IsReady(large));
  revisions_.GoOn();
  EXPECT_OK(large.get());
}

TEST_F(SharedRenderingTest, RenderingEndsWhenAllWhoWantItHaveGone) {
  std::stop_source first;
  std::stop_source second;
  Future one = Export("hall", first);
  Future other = Export("hall", second);
  revisions_.AwaitReading();
  first.request_stop();
  second.request_stop();
  revisions_.GoOn();
  EXPECT_CODE(one.get(), absl::StatusCode::kCancelled);
  EXPECT_CODE(other.get(), absl::StatusCode::kCancelled);
  EXPECT_OK(Export("hall").get()) << "the next one is rendered";
}

TEST_F(SharedRenderingTest, RenderingGoesOnWhileOneWantsIt) {
  std::stop_source gone;
  Future first = Export("hall", gone);
  Future other = Export("hall");
  revisions_.AwaitReading();
  gone.request_stop();
  revisions_.GoOn();
  EXPECT_OK(other.get());
  EXPECT_EQ(revisions_.rasters_read(), 1);
}

TEST_F(SharedRenderingTest, WhoComesWhenTheOthersHaveGoneIsServed) {
  std::stop_source gone;
  Future first = Export("hall", gone);
  revisions_.AwaitReading();
  gone.request_stop();
  Future late = Export("hall");
  revisions_.GoOn();
  EXPECT_CODE(first.get(), absl::StatusCode::kCancelled);
  EXPECT_OK(late.get());
  EXPECT_EQ(revisions_.rasters_read(), 2);
}

TEST_F(SharedRenderingTest, TheEndOfTheServerLeavesNobodyWaiting) {
  Future exported = Export("hall");
  revisions_.AwaitReading();
  std::thread end([this] { exports_.reset(); });
  std::this_thread::sleep_for(std::chrono::milliseconds(20));  // before or after: both must end
  revisions_.GoOn();
  end.join();
  const absl::StatusOr<ExportedMap> map = exported.get();
  EXPECT_TRUE(map.ok() || absl::IsCancelled(map.status())) << map.status().ToString();
}

}  // namespace
}  // namespace enfilade::server
