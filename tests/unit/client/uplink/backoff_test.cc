// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/uplink/backoff.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace enfilade::client {
namespace {

TEST(Backoff, DoublesUpToTheLimitWithinTheUpperHalf) {
  Backoff backoff(0.2, 5.0, 1);
  for (int i = 0; i < 12; ++i) {
    const double whole = std::min(0.2 * std::pow(2.0, i), 5.0);
    const double seconds = backoff.NextSeconds();
    EXPECT_GE(seconds, whole / 2.0);
    EXPECT_LE(seconds, whole);
  }
  backoff.Reset();
  EXPECT_LE(backoff.NextSeconds(), 0.2);
}

TEST(Backoff, SpreadsAFleet) {
  std::set<double> waits;
  for (std::uint64_t robot = 0; robot < 100; ++robot) waits.insert(Backoff(1.0, 30.0, robot).NextSeconds());
  EXPECT_EQ(waits.size(), 100U);
}

}  // namespace
}  // namespace enfilade::client
