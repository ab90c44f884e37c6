// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "server/app/graph/changed_sites.h"
#include "server/app/runtime/stop_signal.h"
#include "server/app/runtime/wake_signal.h"

namespace enfilade::server {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;

TEST(StopSignal, StaysSetAndEndsEveryWait) {
  StopSignal stop;
  EXPECT_FALSE(stop.is_set());
  EXPECT_FALSE(stop.WaitFor(milliseconds(1)));
  std::thread setter([&stop] { stop.Set(); });
  EXPECT_TRUE(stop.WaitFor(hours(1)));
  setter.join();
  EXPECT_TRUE(stop.WaitFor(hours(1))) << "a wait that starts later";
  EXPECT_TRUE(stop.WaitFor(milliseconds(-1))) << "a time that has passed";
  EXPECT_TRUE(stop.is_set());
}

TEST(WakeSignal, AWakeUpBeforeTheWaitIsNotLost) {
  WakeSignal wake;
  wake.Wake();
  wake.WaitFor(hours(1));
}

TEST(WakeSignal, SeveralWakeUpsEndOneWait) {
  WakeSignal wake;
  wake.Wake();
  wake.Wake();
  wake.WaitFor(hours(1));
  const auto begin = std::chrono::steady_clock::now();
  wake.WaitFor(milliseconds(20));
  EXPECT_GE(std::chrono::steady_clock::now() - begin, milliseconds(20)) << "the second wait has to time out";
}

TEST(WakeSignal, WakesAWaitingThread) {
  WakeSignal wake;
  std::thread waiter([&wake] { wake.WaitFor(hours(1)); });
  wake.Wake();
  waiter.join();
}

TEST(ChangedSites, TakeReturnsEachSiteOnce) {
  ChangedSites changed;
  changed.Add(SiteId("a"));
  changed.Add(SiteId("b"));
  changed.Add(SiteId("a"));
  EXPECT_EQ(changed.Take(), (std::set<SiteId>{SiteId("a"), SiteId("b")}));
  EXPECT_TRUE(changed.Take().empty());
  changed.Add(SiteId("a"));
  EXPECT_EQ(changed.Take().size(), 1U);
}

}  // namespace
}  // namespace enfilade::server
