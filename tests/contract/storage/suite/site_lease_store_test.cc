// SPDX-License-Identifier: Apache-2.0
#include "storage/graph/site_lease_store.h"

#include <atomic>
#include <thread>

#include "fmt/format.h"
#include "tests/contract/storage/suite/contract_test.h"

namespace enfilade::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::HasSubstr;

class SiteLeaseStoreTest : public StoreContractTest {
 protected:
  std::optional<storage::SiteLease> Acquire(const std::string& owner, milliseconds ttl = seconds(60)) {
    auto lease = leases_.Acquire(Soon(), site_, owner, ttl);
    EXPECT_OK(lease);
    return lease.ok() ? *std::move(lease) : std::nullopt;
  }
  std::optional<storage::SiteLease> AcquireExpired(const std::string& owner) {
    auto lease = Acquire(owner, milliseconds(1));
    std::this_thread::sleep_for(milliseconds(5));
    return lease;
  }
};

TEST_F(SiteLeaseStoreTest, HasOneHolderAtATime) {
  const auto first = Acquire("first");
  ASSERT_TRUE(first);
  EXPECT_EQ(first->site, site_);
  EXPECT_EQ(first->owner, "first");
  EXPECT_EQ(first->token, 1);
  EXPECT_FALSE(Acquire("second"));
  EXPECT_FALSE(Acquire("first")) << "not even the holder gets it twice";
  ASSERT_OK(leases_.Release(Soon(), *first));
  const auto second = Acquire("second");
  ASSERT_TRUE(second);
  EXPECT_EQ(second->token, 2);
}

TEST_F(SiteLeaseStoreTest, SitesAreLeasedIndependently) {
  backend_->AddSite(SiteId("other"));
  ASSERT_TRUE(Acquire("first"));
  ASSERT_OK_AND_ASSIGN(const auto other, leases_.Acquire(Soon(), SiteId("other"), "first", seconds(60)));
  ASSERT_TRUE(other);
  EXPECT_EQ(other->token, 1);
  EXPECT_STATUS(leases_.Acquire(Soon(), SiteId("nowhere"), "first", seconds(60)), absl::StatusCode::kNotFound,
                HasSubstr("sites/nowhere"));
}

TEST_F(SiteLeaseStoreTest, AnExpiredLeaseIsLostOnlyWhenAnotherTakesIt) {
  const auto lost = AcquireExpired("first");
  ASSERT_TRUE(lost);
  EXPECT_OK(leases_.Renew(Soon(), *lost, milliseconds(1)));
  std::this_thread::sleep_for(milliseconds(5));
  const auto taken = Acquire("second");
  ASSERT_TRUE(taken);
  EXPECT_GT(taken->token, lost->token);
  EXPECT_STATUS(leases_.Renew(Soon(), *lost, seconds(60)), absl::StatusCode::kAborted, HasSubstr("first"));
  EXPECT_OK(leases_.Release(Soon(), *lost)) << "releasing a lost lease is no error";
  EXPECT_FALSE(Acquire("third")) << "and does not take it from its holder";
  EXPECT_OK(leases_.Renew(Soon(), *taken, seconds(60)));
}

TEST_F(SiteLeaseStoreTest, RenewingExtendsTheLease) {
  const auto lease = Acquire("first", milliseconds(500));
  ASSERT_TRUE(lease);
  ASSERT_OK(leases_.Renew(Soon(), *lease, seconds(60)));
  std::this_thread::sleep_for(milliseconds(600));
  EXPECT_FALSE(Acquire("second"));
}

TEST_F(SiteLeaseStoreTest, AReleasedLeaseCannotBeRenewed) {
  const auto lease = Acquire("first");
  ASSERT_TRUE(lease);
  ASSERT_OK(leases_.Release(Soon(), *lease));
  EXPECT_CODE(leases_.Renew(Soon(), *lease, seconds(60)), absl::StatusCode::kAborted);
  EXPECT_OK(leases_.Release(Soon(), *lease));
  EXPECT_TRUE(Acquire("second"));
}

TEST_F(SiteLeaseStoreTest, OneOfManyThatTryAtTheSameTimeGetsIt) {
  for (int round = 1; round <= 3; ++round) {
    std::atomic<int> holders = 0;
    std::atomic<std::int64_t> token = 0;
    std::vector<std::thread> threads;
    for (int i = 0; i < 6; ++i) {
      threads.emplace_back([&, i] {
        const auto lease = leases_.Acquire(Soon(), site_, fmt::format("holder {}", i), seconds(60));
        ASSERT_OK(lease);
        if (!lease->has_value()) return;
        ++holders;
        token = (*lease)->token;
        EXPECT_OK(leases_.Renew(Soon(), **lease, seconds(60)));
      });
    }
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(holders, 1);
    EXPECT_EQ(token, round);
    for (int i = 0; i < 6; ++i) {
      ASSERT_OK(leases_.Release(Soon(), {site_, fmt::format("holder {}", i), token}));
    }
  }
}

}  // namespace
}  // namespace enfilade::testing
