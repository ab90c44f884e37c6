// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/call/call.h"

#include <future>
#include <thread>
#include <vector>

#include "server/rpc/call/request_id.h"
#include "tests/unit/server/rpc/call/call_fixture.h"

namespace enfilade::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;
using ::testing::AllOf;
using ::testing::HasSubstr;

class CallTest : public CallFixture {
 protected:
  // What a task that `run` queues is given.
  struct Turn {
    absl::Status admitted;
    storage::CallContext context;
  };
  template <typename Run>
  static Turn Await(const Run& run) {
    auto turn = std::make_shared<std::promise<Turn>>();
    std::future<Turn> done = turn->get_future();
    run([turn](const absl::Status& admitted, const storage::CallContext& context) {
      turn->set_value({admitted, context});
    });
    return done.get();
  }
  static Turn AwaitRun(const Call& call) {
    return Await([&call](auto task) { call.Run(CallLane::kUsual, task); });
  }
  static Turn AwaitStep(const Call& call) {
    return Await([&call](auto task) { call.RunStep(CallLane::kUsual, task); });
  }
  // Keeps the executor's only thread busy until it is destroyed.
  class Blockage {
   public:
    explicit Blockage(Executor& executor) {
      const auto running = std::make_shared<std::promise<void>>();
      const std::shared_future<void> released = release_.get_future().share();
      EXPECT_TRUE(executor.Post([running, released] {
        running->set_value();
        released.wait();
      }));
      running->get_future().wait();
    }
    ~Blockage() { release_.set_value(); }

   private:
    std::promise<void> release_;
  };
};

TEST_F(CallTest, CarriesWhatTheTransportKnows) {
  const Call call(*environment_,
                  {.rpc = "GetSite", .peer = "ipv4:10.0.0.1:77", .request_id = "abc-1", .actor = "ann@example.org"});
  EXPECT_STREQ(call.rpc(), "GetSite");
  EXPECT_EQ(call.peer(), "ipv4:10.0.0.1:77");
  EXPECT_EQ(call.request_id(), "abc-1");
  EXPECT_EQ(call.principal().name, "ann@example.org");
  EXPECT_FALSE(call.principal().authenticated) << "a name that anybody may claim proves nothing";
  EXPECT_EQ(call.context().actor, "ann@example.org");
  EXPECT_EQ(call.site(), "");
}

TEST_F(CallTest, ReplacesARequestIdThatMayNotBeLogged) {
  const Call forged(*environment_, {.rpc = "GetSite", .request_id = "a\nGetSite failed"});
  EXPECT_TRUE(IsValidRequestId(forged.request_id()));
  const Call other(*environment_, {.rpc = "GetSite"});
  EXPECT_NE(forged.request_id(), other.request_id());
}

TEST_F(CallTest, TakesTheClientsDeadlineOrElseTheDefault) {
  const auto deadline = steady_clock::now() + seconds(5);
  EXPECT_EQ(Call(*environment_, {.rpc = "GetSite", .deadline = deadline}).context().deadline, deadline);

  const auto earliest = steady_clock::now() + environment_->default_timeout;
  const Call call(*environment_, {.rpc = "GetSite"});
  EXPECT_GE(call.context().deadline, earliest);
  EXPECT_LE(call.context().deadline, steady_clock::now() + environment_->default_timeout);
}

TEST_F(CallTest, GivesEachStepOfAnOpenEndedStreamItsOwnDeadline) {
  environment_->default_timeout = milliseconds(40);
  const Call open_ended(*environment_, {.rpc = "WatchGlobalPoses", .actor = "ann"});
  std::this_thread::sleep_for(milliseconds(50));
  EXPECT_LT(open_ended.context().deadline, steady_clock::now());
  const storage::CallContext step = open_ended.StepContext();
  EXPECT_GT(step.deadline, open_ended.context().deadline + milliseconds(50) - milliseconds(1));
  EXPECT_EQ(step.actor, "ann");
  EXPECT_TRUE(step.cancellation.stop_possible());

  const auto deadline = steady_clock::now() + milliseconds(1);
  EXPECT_EQ(Call(*environment_, {.rpc = "WatchGlobalPoses", .deadline = deadline}).StepContext().deadline, deadline)
      << "not beyond what the client allows";
}

TEST_F(CallTest, CancelsEveryContextThatItHasGivenOut) {
  Call call(*environment_, {.rpc = "GetSite"});
  const storage::CallContext before = call.context();
  const storage::CallContext step = call.StepContext();
  EXPECT_FALSE(before.cancellation.stop_requested());
  call.Cancel();
  call.Cancel();
  EXPECT_TRUE(before.cancellation.stop_requested());
  EXPECT_TRUE(step.cancellation.stop_requested());
  EXPECT_TRUE(call.StepContext().cancellation.stop_requested());
}

TEST_F(CallTest, OutlivesItsCancellation) {
  storage::CallContext kept;
  {
    const Call call(*environment_, {.rpc = "GetSite"});
    kept = call.context();
  }
  EXPECT_FALSE(kept.cancellation.stop_requested());
}

TEST_F(CallTest, RunsItsTaskOnTheExecutorWithItsContext) {
  const Call call(*environment_, {.rpc = "GetSite", .actor = "ann"});
  std::thread::id thread;
  call.Run(CallLane::kUsual,
           [&thread](const absl::Status&, const storage::CallContext&) { thread = std::this_thread::get_id(); });
  const Turn turn = AwaitRun(call);
  EXPECT_OK(turn.admitted);
  EXPECT_EQ(turn.context.deadline, call.context().deadline);
  EXPECT_EQ(turn.context.actor, "ann");
  EXPECT_NE(thread, std::thread::id()) << "tasks run in order";
  EXPECT_NE(thread, std::this_thread::get_id());
}

TEST_F(CallTest, DoesNotWorkForAClientThatHasGone) {
  Call call(*environment_, {.rpc = "GetSite"});
  call.Cancel();
  EXPECT_CODE(AwaitRun(call).admitted, absl::StatusCode::kCancelled);
  EXPECT_CODE(AwaitStep(call).admitted, absl::StatusCode::kCancelled);
}

TEST_F(CallTest, DoesNotWorkAfterTheDeadline) {
  const Call call(*environment_, {.rpc = "GetSite", .deadline = steady_clock::now() - milliseconds(1)});
  EXPECT_CODE(AwaitRun(call).admitted, absl::StatusCode::kDeadlineExceeded);
  EXPECT_CODE(AwaitStep(call).admitted, absl::StatusCode::kDeadlineExceeded);
}

TEST_F(CallTest, LetsAStepRunLongAfterTheStreamBegan) {
  environment_->default_timeout = milliseconds(100);
  const Call call(*environment_, {.rpc = "StreamRecords"});
  std::this_thread::sleep_for(milliseconds(120));
  EXPECT_CODE(AwaitRun(call).admitted, absl::StatusCode::kDeadlineExceeded);
  EXPECT_OK(AwaitStep(call).admitted);
}

TEST_F(CallTest, NoticesWhatHappensWhileItWaitsForItsTurn) {
  Call cancelled(*environment_, {.rpc = "GetSite"});
  const Call late(*environment_, {.rpc = "GetSite", .deadline = steady_clock::now() + milliseconds(5)});
  absl::Status of_cancelled;
  absl::Status of_late;
  {
    const Blockage blockage(executor_);
    cancelled.Run(CallLane::kUsual,
                  [&](const absl::Status& admitted, const storage::CallContext&) { of_cancelled = admitted; });
    late.Run(CallLane::kUsual, [&](const absl::Status& admitted, const storage::CallContext&) { of_late = admitted; });
    cancelled.Cancel();
    std::this_thread::sleep_until(late.context().deadline);
  }
  executor_.Stop();
  EXPECT_CODE(of_cancelled, absl::StatusCode::kCancelled);
  EXPECT_CODE(of_late, absl::StatusCode::kDeadlineExceeded);
}

class BoundedCallTest : public CallFixture {
 protected:
  BoundedCallTest() : CallFixture(/*max_queued=*/1) {}
};

TEST_F(BoundedCallTest, RefusesWhatTheExecutorCannotTakeAndQueuesStepsAllTheSame) {
  const Call call(*environment_, {.rpc = "GetSite"});
  std::promise<void> release;
  std::promise<void> running;
  ASSERT_TRUE(executor_.Post([&] {
    running.set_value();
    release.get_future().wait();
  }));
  running.get_future().wait();
  std::vector<absl::Status> admitted;  // filled by this thread, then by the executor's only one
  const auto note = [&admitted](const absl::Status& status, const storage::CallContext&) {
    admitted.push_back(status);
  };
  call.Run(CallLane::kUsual, note);  // fills the queue
  EXPECT_TRUE(admitted.empty());
  call.Run(CallLane::kUsual, note);
  call.RunStep(CallLane::kUsual, note);
  ASSERT_EQ(admitted.size(), 2U);
  EXPECT_STATUS(admitted[0], absl::StatusCode::kResourceExhausted, ::testing::HasSubstr("try again"));
  EXPECT_CODE(admitted[1], absl::StatusCode::kResourceExhausted);
  std::promise<void> continued;
  call.Continue([&continued] { continued.set_value(); });
  release.set_value();
  continued.get_future().wait();
  executor_.Stop();
  ASSERT_EQ(admitted.size(), 3U);
  EXPECT_OK(admitted[2]);
}

TEST_F(CallTest, LogsAFailureWithAllThatFindsItAgain) {
  Call call(*environment_,
            {.rpc = "GetMap", .peer = "ipv4:10.0.0.1:77", .request_id = "id-17", .actor = "ann@example.org"});
  call.set_site("hq");
  call.Finish(absl::InternalError("the shelf is bent"));
  EXPECT_THAT(Log(), AllOf(HasSubstr("GetMap"), HasSubstr("INTERNAL: the shelf is bent"), HasSubstr("request id-17"),
                           HasSubstr("peer ipv4:10.0.0.1:77"), HasSubstr("principal \"ann@example.org\""),
                           HasSubstr("site \"hq\"")));
}

TEST_F(CallTest, LogsByTheFaultOfServerOrClient) {
  const auto logged = [this](absl::StatusCode code) {
    log_.str("");
    Call(*environment_, {.rpc = "GetSite"}).Finish(absl::Status(code, "why"));
    const std::string line = Log();
    return line.substr(0, line.find(':'));
  };
  EXPECT_EQ(logged(absl::StatusCode::kOk), "");
  EXPECT_EQ(logged(absl::StatusCode::kCancelled), "debug") << "how every watch ends";
  for (const auto code :
       {absl::StatusCode::kInvalidArgument, absl::StatusCode::kNotFound, absl::StatusCode::kAlreadyExists,
        absl::StatusCode::kPermissionDenied, absl::StatusCode::kFailedPrecondition, absl::StatusCode::kAborted,
        absl::StatusCode::kUnavailable, absl::StatusCode::kDeadlineExceeded}) {
    EXPECT_EQ(logged(code), "info") << absl::StatusCodeToString(code);
  }
  for (const auto code : {absl::StatusCode::kInternal, absl::StatusCode::kUnknown, absl::StatusCode::kDataLoss,
                          absl::StatusCode::kResourceExhausted}) {
    EXPECT_EQ(logged(code), "warning") << absl::StatusCodeToString(code);
  }
}

TEST_F(CallTest, LogsNothingBelowTheLoggersLevel) {
  logger_->set_level(spdlog::level::warn);
  Call(*environment_, {.rpc = "GetSite"}).Finish(absl::NotFoundError("no such site"));
  EXPECT_EQ(Log(), "");
}

}  // namespace
}  // namespace enfilade::server
