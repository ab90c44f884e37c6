// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/judging_lease.h"

#include <gtest/gtest.h>

#include <optional>

#include "tests/fakes/in_memory_stores.h"
#include "tests/support/status_assertions.h"

namespace enfilade::server {
namespace {

using std::chrono::seconds;
using testing::InMemoryDatabase;
using testing::InMemorySiteLeaseStore;

// Counts renewals.
class LeaseProbe final : public storage::SiteLeaseStore {
 public:
  explicit LeaseProbe(const storage::SiteLeaseStore& store) : store_(store) {}

  absl::StatusOr<std::optional<storage::SiteLease>> Acquire(const storage::CallContext& context, const SiteId& site,
                                                            const std::string& owner,
                                                            std::chrono::milliseconds ttl) const override {
    return store_.Acquire(context, site, owner, ttl);
  }
  absl::Status Renew(const storage::CallContext& context, const storage::SiteLease& lease,
                     std::chrono::milliseconds ttl) const override {
    ++renewals_;
    return store_.Renew(context, lease, ttl);
  }
  absl::Status Release(const storage::CallContext& context, const storage::SiteLease& lease) const override {
    return store_.Release(context, lease);
  }

  int renewals() const { return renewals_; }

 private:
  const storage::SiteLeaseStore& store_;
  mutable int renewals_ = 0;
};

class JudgingLeaseTest : public ::testing::Test {
 protected:
  static JudgingLease::Clock::time_point Now() { return now_; }
  void Pass(seconds time) {
    now_ += time;
    database_.AdvanceClock(time);
  }
  std::optional<storage::SiteLease> Acquire(const std::string& owner) {
    return *leases_.Acquire(JudgingLease::Context(), SiteId("a"), owner, JudgingLease::kTime);
  }

  JudgingLeaseTest() { database_.AddSite(SiteId("a")); }

  inline static JudgingLease::Clock::time_point now_;
  InMemoryDatabase database_;
  const InMemorySiteLeaseStore leases_{database_, storage::SiteRight::kChange};
  const LeaseProbe probe_{leases_};
  StopSignal stop_;
};

TEST_F(JudgingLeaseTest, ComparisonsWithManyMapsCommitNothing) {
  const auto held = Acquire("one");
  const JudgingLease lease(probe_, *held, stop_, Now);
  for (int map = 0; map < 40; ++map) ASSERT_OK(lease.Renew());
  EXPECT_EQ(probe_.renewals(), 0);
}

TEST_F(JudgingLeaseTest, IsKeptHoweverLongJudgingTakes) {
  const auto held = Acquire("one");
  const JudgingLease lease(probe_, *held, stop_, Now);
  for (int i = 0; i < 100; ++i) {
    Pass(seconds(1));
    ASSERT_OK(lease.Renew());
    ASSERT_FALSE(Acquire("another"));
  }
  EXPECT_EQ(probe_.renewals(), 20);
}

TEST_F(JudgingLeaseTest, IsLostToAnotherOnceItHasRunOut) {
  const auto held = Acquire("one");
  const JudgingLease lease(probe_, *held, stop_, Now);
  Pass(JudgingLease::kTime + seconds(1));
  ASSERT_TRUE(Acquire("another"));
  EXPECT_CODE(lease.Renew(), absl::StatusCode::kAborted);
}

TEST_F(JudgingLeaseTest, EndsAtOnceWhenTheServerStops) {
  const auto held = Acquire("one");
  const JudgingLease lease(probe_, *held, stop_, Now);
  stop_.Set();
  EXPECT_CODE(lease.Renew(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace enfilade::server
