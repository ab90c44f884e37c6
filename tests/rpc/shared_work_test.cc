// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "core/base/sha256.h"
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

}  // namespace
}  // namespace enfilade::testing
