// SPDX-License-Identifier: Apache-2.0
#include "server/app/runtime/maintenance_loop.h"

#include <gmock/gmock.h>

#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "core/base/mutex.h"

namespace enfilade::server {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr std::int64_t kFull = MaintenanceLoop::kPortionRows;

// Jobs whose portions are scripted; records which job was asked for a portion.
class Script {
 public:
  // Answers of job `name`, one per portion; 0 when they are used up.
  MaintenanceJob Job(const std::string& name, std::vector<absl::StatusOr<std::int64_t>> answers) {
    return {name, [this, name, answers, next = std::size_t{0}](const storage::CallContext& context,
                                                               std::int64_t limit) mutable {
              EXPECT_EQ(limit, kFull);
              EXPECT_GT(context.deadline, std::chrono::steady_clock::now());
              MutexLock lock(mutex_);
              calls_.push_back(name);
              changed_.NotifyAll();
              return next < answers.size() ? answers[next++] : absl::StatusOr<std::int64_t>(0);
            }};
  }
  std::vector<std::string> AwaitCalls(std::size_t count) {
    MutexLock lock(mutex_);
    while (calls_.size() < count) changed_.Wait(mutex_);
    return {calls_.begin(), calls_.begin() + static_cast<std::ptrdiff_t>(count)};
  }
  std::vector<std::string> calls() {
    MutexLock lock(mutex_);
    return calls_;
  }
  void AwaitTicks(int more) {
    MutexLock lock(mutex_);
    const int wanted = ticks_ + more;
    while (ticks_ < wanted) changed_.Wait(mutex_);
  }

  MaintenanceLoop::Options Every(std::chrono::milliseconds interval) {
    return {.interval = interval,
            .tick = std::chrono::milliseconds(1),
            .is_ready = [this] { return ready_.load(); },
            .on_tick =
                [this] {
                  MutexLock lock(mutex_);
                  ++ticks_;
                  changed_.NotifyAll();
                }};
  }

  std::atomic<bool> ready_{true};

 private:
  Mutex mutex_;
  CondVar changed_;
  std::vector<std::string> calls_;
  int ticks_ = 0;
};

TEST(MaintenanceLoop, RunsEveryJobUntilAPortionIsNotFull) {
  Script script;
  const MaintenanceLoop loop(script.Every(std::chrono::milliseconds(1)),
                             {script.Job("a", {kFull, kFull, 1}), script.Job("b", {}), script.Job("c", {kFull})});
  EXPECT_THAT(script.AwaitCalls(7), ElementsAre("a", "a", "a", "b", "c", "c", "a"));
}

TEST(MaintenanceLoop, AFailedJobIsTriedAgainInTheNextRound) {
  Script script;
  const MaintenanceLoop loop(script.Every(std::chrono::milliseconds(1)),
                             {script.Job("a", {kFull, absl::UnavailableError("gone")}), script.Job("b", {})});
  EXPECT_THAT(script.AwaitCalls(5), ElementsAre("a", "a", "b", "a", "b"));
}

TEST(MaintenanceLoop, WaitsForTheInterval) {
  Script script;
  const MaintenanceLoop loop(script.Every(std::chrono::hours(1)), {script.Job("a", {})});
  script.AwaitTicks(20);
  EXPECT_THAT(script.calls(), IsEmpty());
}

TEST(MaintenanceLoop, SkipsRoundsWhileTheServerIsNotReady) {
  Script script;
  script.ready_ = false;
  const MaintenanceLoop loop(script.Every(std::chrono::milliseconds(1)), {script.Job("a", {})});
  script.AwaitTicks(20);
  EXPECT_THAT(script.calls(), IsEmpty());
  script.ready_ = true;
  script.AwaitCalls(1);
}

TEST(MaintenanceLoop, StopsBetweenPortions) {
  Script script;
  std::optional<MaintenanceLoop> loop;
  // Without a stop this job would never end.
  loop.emplace(script.Every(std::chrono::milliseconds(1)),
               std::vector<MaintenanceJob>{{"endless", [&script](const storage::CallContext& context, std::int64_t n) {
                                              return script.Job("a", {kFull}).do_portion(context, n);
                                            }}});
  script.AwaitCalls(3);
  loop.reset();
}

}  // namespace
}  // namespace enfilade::server
