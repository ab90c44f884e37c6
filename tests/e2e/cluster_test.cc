// SPDX-License-Identifier: Apache-2.0
// deploy/database/cluster after kill -9.
#include "tests/support/cluster.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <fstream>
#include <string>
#include <thread>

#include "tests/support/eventually.h"

namespace enfilade::testing {
namespace {

TEST(ClusterTest, StartsAgainOnceTheLastProcessOfAKilledServerIsGone) {
  Cluster cluster(Cluster::Durability::kFast);
  const pid_t postmaster = cluster.pid();
  const std::string task = "/proc/" + std::to_string(postmaster) + "/task/" + std::to_string(postmaster);
  pid_t child = 0;
  std::ifstream(task + "/children") >> child;
  ASSERT_GT(child, 1);
  // It cannot notice that its postmaster has ended, and keeps the shared memory.
  ASSERT_EQ(kill(child, SIGSTOP), 0);
  ASSERT_EQ(kill(postmaster, SIGKILL), 0);
  ASSERT_TRUE(Eventually([&] { return kill(postmaster, 0) != 0; }));
  std::thread later([child] {
    std::this_thread::sleep_for(std::chrono::seconds(8));
    kill(child, SIGCONT);
  });
  EXPECT_NO_THROW(cluster.Restart());
  later.join();
  EXPECT_NE(cluster.pid(), postmaster);
}

}  // namespace
}  // namespace enfilade::testing
