// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "client/sdk/api/map_export.h"
#include "client/sdk/api/map_import.h"
#include "storage/postgres/driver/transaction.h"
#include "tests/rpc/graph_fixture.h"

namespace enfilade::testing {
namespace {

// More than the executor has threads.
constexpr int kCallers = 20;
constexpr int kQuickCalls = 50;

// Calls for work that takes long, such as reading a large graph, share it and leave the others' threads alone. A test
// holds that work up by locking a table that it reads.
class SharedWorkTest : public GraphTest {
 protected:
  storage::postgres::Transaction LockTable(const storage::postgres::Statement& lock) {
    auto transaction = storage::postgres::Transaction::Begin(*pool_, Soon());
    EXPECT_OK(transaction);
    EXPECT_OK(transaction->Execute(lock, storage::postgres::Params()));
    return *std::move(transaction);
  }
  // How many of the server's statements wait for the lock.
  int CountHeldUp(const std::string& table) const {
    return std::stoi(
        database_.SqlValue("SELECT count(*) FROM pg_locks WHERE NOT granted AND relation = '" + table + "'::regclass"));
  }
  void AwaitHeldUp(const std::string& table) const {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (CountHeldUp(table) == 0 && std::chrono::steady_clock::now() < until) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }
  static v1::FindRoutesRequest Route() {
    v1::FindRoutesRequest request;
    request.set_start_map("sites/s/maps/m");
    request.set_goal_map("sites/s/maps/c");
    request.mutable_pose_map_start();
    request.mutable_pose_map_goal();
    return request;
  }
  // One after the other: the first ones may come before those that are held up.
  void ExpectQuickCallsAreAnswered() const {
    const client::Connection quick(server_->address(), std::chrono::seconds(10));
    v1::GetSiteRequest request;
    request.set_name("sites/s");
    for (int i = 0; i < kQuickCalls; ++i) ASSERT_OK(quick.Call(&v1::SiteService::Stub::GetSite, request));
  }
};

TEST_F(SharedWorkTest, CallsThatNeedAGraphThatIsBeingReadHoldNoThreads) {
  constexpr storage::postgres::Statement kLock{"locking",
                                               "LOCK TABLE enfilade.graph_removals IN ACCESS EXCLUSIVE MODE"};
  Restart(Options());  // no graph is cached
  std::atomic<int> answered{0};
  std::vector<std::thread> callers;
  {
    const storage::postgres::Transaction lock = LockTable(kLock);
    for (int i = 0; i < kCallers; ++i) {
      callers.emplace_back([this, i, &answered] {
        const absl::Status status = i % 2 == 0 ? Call(&v1::GraphService::Stub::GetGlobalPose, At("c", {})).status()
                                               : Call(&v1::GraphService::Stub::FindRoutes, Route()).status();
        EXPECT_OK(status);
        ++answered;
      });
    }
    AwaitHeldUp("enfilade.graph_removals");
    ExpectQuickCallsAreAnswered();
    EXPECT_EQ(CountHeldUp("enfilade.graph_removals"), 1) << "one read for all";
    EXPECT_EQ(answered, 0);
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(answered, kCallers);
}

TEST_F(SharedWorkTest, ExportsThatWaitForTheirFilesHoldNoThreads) {
  constexpr storage::postgres::Statement kLock{"locking",
                                               "LOCK TABLE enfilade.map_revision_tiles IN ACCESS EXCLUSIVE MODE"};
  std::string pixels(64 * 32, '\xFE');
  pixels[0] = '\0';  // a raster of one value has no tiles
  ASSERT_OK(client::ImportMap(*connection_, "sites/s/maps/m", v1::MAP_DIALECT_UNSPECIFIED,
                              {{{"hall.pgm", "P5\n64 32\n255\n" + pixels},
                                {"hall.yaml",
                                 "image: hall.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n"
                                 "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"}}}));
  v1::ExportMapRequest request;
  request.set_name("sites/s/maps/m");
  request.set_format(v1::MAP_FORMAT_PGM);
  std::atomic<int> answered{0};
  std::vector<std::thread> callers;
  {
    const storage::postgres::Transaction lock = LockTable(kLock);
    for (int i = 0; i < kCallers; ++i) {
      callers.emplace_back([this, &request, &pixels, &answered] {
        const auto map = client::DownloadMap(*connection_, request);
        EXPECT_OK(map);
        EXPECT_TRUE(map.ok() && map->files[0].bytes.ends_with(pixels));
        ++answered;
      });
    }
    AwaitHeldUp("enfilade.map_revision_tiles");
    ExpectQuickCallsAreAnswered();
    EXPECT_EQ(CountHeldUp("enfilade.map_revision_tiles"), 1) << "one rendering for all";
    EXPECT_EQ(answered, 0);
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(answered, kCallers);
}

TEST_F(SharedWorkTest, CallsThatComputeForSecondsHaveThreadsOfTheirOwn) {
  constexpr storage::postgres::Statement kLock{"locking", "LOCK TABLE enfilade.site_leases IN ACCESS EXCLUSIVE MODE"};
  v1::OptimizeGraphRequest request;
  request.set_site("sites/s");
  std::atomic<int> answered{0};
  std::vector<std::thread> callers;
  {
    const storage::postgres::Transaction lock = LockTable(kLock);
    for (int i = 0; i < kCallers; ++i) {
      callers.emplace_back([this, &request, &answered] {
        EXPECT_OK(Call(&v1::GraphService::Stub::OptimizeGraph, request));
        ++answered;
      });
    }
    AwaitHeldUp("enfilade.site_leases");
    ExpectQuickCallsAreAnswered();
    EXPECT_EQ(answered, 0);
  }
  for (std::thread& caller : callers) caller.join();
}

}  // namespace
}  // namespace enfilade::testing
