// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/graph_version_waits.h"

#include <latch>

#include "tests/unit/server/app/graph/graph_test.h"

namespace enfilade::server {
namespace {

using ::testing::HasSubstr;
using Listening = GraphStoreProbe::Listening;
using std::chrono::steady_clock;

class GraphVersionWaitsTest : public AppGraphTest {
 protected:
  static absl::Status Await(GraphVersionWaits& waits, const SiteId& site, std::int64_t version) {
    absl::Status result;
    std::latch done(1);
    waits.Await(site, version, steady_clock::now() + std::chrono::hours(1), [&](const absl::Status& status) {
      result = status;
      done.count_down();
    });
    done.wait();
    return result;
  }
};

TEST_F(GraphVersionWaitsTest, ReadsAVersionThatNothingHasTold) {
  probe_.set_listening(Listening::kSilent);
  StartListening();
  GraphVersionWaits waits(*graphs_, std::chrono::hours(1));
  for (int i = 0; i < 20; ++i) {
    const std::int64_t version = MoveDoor(11.0 + i);
    EXPECT_OK(Await(waits, site_, version));
    ASSERT_NE(graphs_->FindCurrent(site_), nullptr);
    EXPECT_GE(graphs_->FindCurrent(site_)->graph().version(), version);
  }
  const int reads = probe_.reads();
  EXPECT_OK(Await(waits, site_, Version()));
  EXPECT_OK(Await(waits, site_, 1));
  EXPECT_EQ(probe_.reads(), reads) << "it is there already";
}

TEST_F(GraphVersionWaitsTest, TellsToCallAgainIfTheVersionDoesNotCome) {
  StartListening();
  GraphVersionWaits waits(*graphs_, std::chrono::milliseconds(120));
  EXPECT_STATUS(Await(waits, site_, Version() + 1), absl::StatusCode::kUnavailable, HasSubstr("call again"));
  EXPECT_NE(graphs_->FindCurrent(site_), nullptr) << "others are not held up";
  EXPECT_CODE(Await(waits, SiteId("nowhere"), 1), absl::StatusCode::kNotFound);
}

TEST_F(GraphVersionWaitsTest, TheVersionMayComeWhileACallWaits) {
  StartListening();
  GraphVersionWaits waits(*graphs_, std::chrono::hours(1));
  std::latch done(1);
  waits.Await(site_, Version() + 1, steady_clock::now() + std::chrono::hours(1), [&](const absl::Status& status) {
    EXPECT_OK(status);
    done.count_down();
  });
  EXPECT_FALSE(done.try_wait());
  MoveDoor(12.0);
  done.wait();
}

TEST_F(GraphVersionWaitsTest, ThoseWhoWaitAreAnsweredAtTheDeadlineAndAtTheEnd) {
  StartListening();
  GraphVersionWaits waits(*graphs_, std::chrono::hours(1));
  std::latch late(1);
  waits.Await(site_, Version() + 1, steady_clock::now(), [&](const absl::Status& status) {
    EXPECT_CODE(status, absl::StatusCode::kUnavailable);
    late.count_down();
  });
  late.wait();
  absl::Status at_the_end;
  {
    GraphVersionWaits ending(*graphs_, std::chrono::hours(1));
    ending.Await(site_, Version() + 1, steady_clock::now() + std::chrono::hours(1),
                 [&](const absl::Status& status) { at_the_end = status; });
  }
  EXPECT_CODE(at_the_end, absl::StatusCode::kUnavailable);
}

}  // namespace
}  // namespace enfilade::server
