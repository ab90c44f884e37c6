// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/site_backoff.h"

#include <gtest/gtest.h>

namespace enfilade::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(SiteBackoff, WaitsTwiceAsLongAfterEachFailureUpToAMinute) {
  SiteBackoff backoff;
  SiteBackoff::Time now;
  const SiteId site("campus");
  EXPECT_TRUE(backoff.IsDue(site, now));
  for (const int wait : {1, 2, 4, 8, 16, 32, 60, 60}) {
    EXPECT_EQ(backoff.Fail(site, now), seconds(wait));
    EXPECT_FALSE(backoff.IsDue(site, now + seconds(wait) - milliseconds(1)));
    EXPECT_TRUE(backoff.IsDue(SiteId("other"), now));
    now += seconds(wait);
    EXPECT_TRUE(backoff.IsDue(site, now));
  }
}

TEST(SiteBackoff, BeginsAnewAfterASuccess) {
  SiteBackoff backoff;
  const SiteBackoff::Time now;
  backoff.Fail(SiteId("campus"), now);
  backoff.Fail(SiteId("campus"), now);
  backoff.Succeed(SiteId("campus"));
  EXPECT_TRUE(backoff.IsDue(SiteId("campus"), now));
  EXPECT_EQ(backoff.Fail(SiteId("campus"), now), SiteBackoff::kFirst);
}

}  // namespace
}  // namespace enfilade::server
