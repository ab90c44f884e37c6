// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <future>
#include <latch>
#include <stop_token>
#include <thread>

#include "tests/unit/server/app/graph/graph_test.h"

namespace enfilade::server {
namespace {

using Listening = GraphStoreProbe::Listening;

class SharedReadsTest : public AppGraphTest {};

// Holds up the first read until it is destroyed.
class HeldRead {
 public:
  explicit HeldRead(GraphStoreProbe& probe) {
    probe.set_after_read([state = state_] {
      if (state->held.exchange(true)) return;
      state->reading.count_down();
      state->go_on.wait();
    });
  }
  ~HeldRead() { GoOn(); }
  void AwaitReading() { state_->reading.wait(); }
  void GoOn() {
    if (!state_->gone_on.exchange(true)) state_->go_on.count_down();
  }

 private:
  struct State {
    std::atomic<bool> held{false};
    std::atomic<bool> gone_on{false};
    std::latch reading{1};
    std::latch go_on{1};
  };
  const std::shared_ptr<State> state_ = std::make_shared<State>();
};

TEST_F(SharedReadsTest, ManyThatPrepareShareOneReadAndNoneWaits) {
  StartListening();
  graphs_->Forget(site_);
  const int before = probe_.reads();
  HeldRead held(probe_);
  std::atomic<int> ready{0};
  std::latch all_ready(100);
  for (int i = 0; i < 100; ++i) {
    graphs_->Prepare(site_, [&](const absl::Status& status) {
      EXPECT_OK(status);
      EXPECT_NE(graphs_->FindCurrent(site_), nullptr);
      ++ready;
      all_ready.count_down();
    });
  }
  held.AwaitReading();
  EXPECT_EQ(ready, 0);
  EXPECT_OK(graphs_->Get(Soon(), other_site_)) << "another site's graph is read meanwhile";
  held.GoOn();
  all_ready.wait();
  EXPECT_EQ(probe_.reads(), before + 2) << "one for each site";
  graphs_->Prepare(site_, [&](const absl::Status&) { ++ready; });
  EXPECT_EQ(ready, 101) << "at once: it is at hand";
}

TEST_F(SharedReadsTest, ThoseWhoPrepareLearnWhatWentWrong) {
  Start();
  std::promise<absl::Status> nowhere;
  graphs_->Prepare(SiteId("nowhere"), [&](const absl::Status& status) { nowhere.set_value(status); });
  EXPECT_CODE(nowhere.get_future().get(), absl::StatusCode::kNotFound);
}

TEST_F(SharedReadsTest, NoMoreThanAThousandPrepareAtATime) {
  HeldRead held(probe_);
  Start();
  std::atomic<int> ready{0};
  std::latch all_ready(1000);
  for (int i = 0; i < 1000; ++i) {
    graphs_->Prepare(site_, [&](const absl::Status& status) {
      EXPECT_OK(status);
      ++ready;
      all_ready.count_down();
    });
  }
  absl::Status refused;
  graphs_->Prepare(site_, [&](const absl::Status& status) { refused = status; });
  EXPECT_CODE(refused, absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ready, 0);
  held.GoOn();
  all_ready.wait();
  std::promise<absl::Status> again;
  graphs_->Prepare(site_, [&](const absl::Status& status) { again.set_value(status); });
  EXPECT_OK(again.get_future().get());
}

TEST_F(SharedReadsTest, ACallerWaitsForAReadNoLongerThanItWants) {
  HeldRead held(probe_);
  Start();
  graphs_->Prepare(site_, [](const absl::Status&) {});
  held.AwaitReading();
  EXPECT_CODE(graphs_->Get(storage::CallContext::WithTimeout(std::chrono::milliseconds(20)), site_),
              absl::StatusCode::kDeadlineExceeded);
  std::stop_source cancellation;
  storage::CallContext context = Soon();
  context.cancellation = cancellation.get_token();
  std::thread client([&] { cancellation.request_stop(); });
  EXPECT_CODE(graphs_->Get(context, site_), absl::StatusCode::kCancelled);
  client.join();
}

// The change is committed while an older state is read: the answer must not be that state.
TEST_F(SharedReadsTest, ACallDuringAReadGetsWhatWasChangedBeforeTheCall) {
  probe_.set_listening(Listening::kBroken);
  HeldRead held(probe_);
  Start();
  std::promise<void> first;
  graphs_->Prepare(site_, [&](const absl::Status&) { first.set_value(); });
  held.AwaitReading();
  const std::int64_t after = MoveDoor(12);
  std::promise<std::int64_t> seen;
  std::thread reader([&] { seen.set_value(Get()->graph().version()); });
  std::this_thread::sleep_for(std::chrono::milliseconds(20));  // it may call before or after the read: both must hold
  held.GoOn();
  EXPECT_EQ(seen.get_future().get(), after);
  first.get_future().get();
  reader.join();
}

}  // namespace
}  // namespace enfilade::server
