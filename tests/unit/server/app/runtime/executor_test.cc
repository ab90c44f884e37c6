// SPDX-License-Identifier: Apache-2.0
#include "server/app/runtime/executor.h"

#include <gmock/gmock.h>

#include <atomic>
#include <latch>
#include <vector>

namespace enfilade::server {
namespace {

using ::testing::ElementsAre;

// Occupies one thread of an executor until Open, so that what is posted meanwhile stays queued.
class Gate {
 public:
  std::function<void()> task() {
    return [this] {
      entered_.count_down();
      open_.wait();
    };
  }
  void AwaitEntered() { entered_.wait(); }
  void Open() { open_.count_down(); }

 private:
  std::latch entered_{1};
  std::latch open_{1};
};

TEST(Executor, OneThreadRunsTasksInTheirOrder) {
  std::vector<int> order;  // of the executor's one thread
  {
    Executor executor(1, 100);
    for (int i = 0; i < 4; ++i) ASSERT_TRUE(executor.Post([&order, i] { order.push_back(i); }));
  }
  EXPECT_THAT(order, ElementsAre(0, 1, 2, 3));
}

TEST(Executor, RefusesTasksWhileTheQueueIsFull) {
  std::atomic<int> ran{0};
  Gate gate;
  Executor executor(1, 2);
  ASSERT_TRUE(executor.Post(gate.task()));
  gate.AwaitEntered();  // no longer in the queue
  EXPECT_TRUE(executor.Post([&ran] { ++ran; }));
  EXPECT_TRUE(executor.Post([&ran] { ++ran; }));
  EXPECT_FALSE(executor.Post([&ran] { ran += 100; }));
  gate.Open();
  executor.Stop();
  EXPECT_EQ(ran, 2) << "the refused task must not run";
}

TEST(Executor, TheNextStepOfAnAcceptedCallIsQueuedBeyondTheBound) {
  std::atomic<int> ran{0};
  Gate gate;
  Executor executor(1, 1);
  ASSERT_TRUE(executor.Post(gate.task()));
  gate.AwaitEntered();
  ASSERT_TRUE(executor.Post([&ran] { ++ran; }));
  executor.PostNext([&ran] { ++ran; });
  executor.PostNext([&ran] { ++ran; });
  EXPECT_FALSE(executor.Post([&ran] { ran += 100; })) << "steps beyond the bound count towards it";
  gate.Open();
  executor.Stop();
  EXPECT_EQ(ran, 3);
}

TEST(Executor, StopRunsWhatIsQueuedAndWhatThatPosts) {
  std::atomic<int> ran{0};
  Gate gate;
  Executor executor(1, 10);
  ASSERT_TRUE(executor.Post(gate.task()));
  gate.AwaitEntered();
  ASSERT_TRUE(executor.Post([&] { executor.PostNext([&ran] { ++ran; }); }));
  gate.Open();
  executor.Stop();
  EXPECT_EQ(ran, 1);
  executor.Stop();  // no-op
}

TEST(Executor, ThreadsRunTasksConcurrently) {
  Executor executor(3, 10);
  std::latch all_running(3);  // opens only if three tasks run at the same time
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(executor.Post([&all_running] { all_running.arrive_and_wait(); }));
  executor.Stop();
  EXPECT_TRUE(all_running.try_wait());
}

}  // namespace
}  // namespace enfilade::server
