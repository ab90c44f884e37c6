// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/app/runtime/executor.h"
#include "server/app/runtime/metrics.h"
#include "server/rpc/call/principal.h"
#include "spdlog/logger.h"
#include "storage/call_context.h"

namespace enfilade::server {

// The part of the server that all calls use. Must outlive them.
struct CallEnvironment {
  Executor& executor;
  // Makes large answers: few threads, so that they leave processors to other calls. Null: `executor`.
  Executor* bulk = nullptr;
  // Calls that compute for seconds, or take much memory: few threads, so that neither processors nor connections to the
  // database are taken from other calls. Null: `executor`.
  Executor* slow = nullptr;
  // Makes messages of watches, however many there are, so that other calls do not wait for them. Null: `executor`.
  Executor* watches = nullptr;
  Metrics& metrics;
  std::shared_ptr<spdlog::logger> logger;
  // Of a call whose client set no deadline, and of each step of an open-ended stream.
  std::chrono::steady_clock::duration default_timeout;
  // Whether a site, by its id, is being deleted. Unset: none is.
  std::function<bool(std::string_view)> is_being_deleted = {};
};

// What the transport knows about a call. ReadIncomingCall() makes it from gRPC's context.
struct IncomingCall {
  const char* rpc;  // its name, for metrics and logs; a string literal
  std::string peer = {};
  std::string_view request_id = {};   // request metadata "x-request-id"; empty if not set
  std::string_view certificate = {};  // the name in the client's certificate; empty if it has none
  std::string_view actor = {};        // request metadata "enfilade-actor"; empty if not set
  // Request metadata "enfilade-min-graph-version", of any sites.
  std::vector<std::string> min_graph_versions = {};
  std::optional<std::chrono::steady_clock::time_point> deadline = {};  // unset: the client set none
};

// Where a call's work is done: lanes have threads and queues of their own, so that none fills another.
enum class CallLane { kUsual, kBulk, kSlow };

// One call of the API, whatever its shape, from its arrival to its end. Every RPC gets one. Authentication, quotas and
// tracing belong here and in the functions that this calls. Thread-safe except for set_site().
class Call {
 public:
  Call(const CallEnvironment& environment, const IncomingCall& incoming);
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;

  const char* rpc() const { return rpc_; }
  // The client's choice, or a new one if that is missing or invalid. It is in the log line of a failure and in the
  // response's metadata.
  const std::string& request_id() const { return request_id_; }
  const std::string& peer() const { return peer_; }
  const Principal& principal() const { return principal_; }
  spdlog::logger& logger() const { return *environment_.logger; }

  // The id of the site that the request names; empty if it names none.
  const std::string& site() const { return site_; }
  // Called before the call is handed to other threads.
  void set_site(std::string site) { site_ = std::move(site); }
  // The version of the site's graph that the answer must at least be made from; 0: any. INVALID_ARGUMENT if what the
  // client sent is not of the form sites/SITE=VERSION.
  absl::StatusOr<std::int64_t> MinGraphVersion() const;
  // FAILED_PRECONDITION if the site is being deleted, unless the call is one of the few that may see it then.
  absl::Status CheckSite() const;

  // For calls of the stores: the client's deadline, or the default from the call's arrival if it set none; the
  // principal as the actor; cancelled with the call.
  const storage::CallContext& context() const { return context_; }
  // The same for one step of an open-ended stream: the default timeout from now, at most up to the client's deadline.
  storage::CallContext StepContext() const;

  // The client has gone. May be repeated.
  void Cancel() { cancellation_.request_stop(); }

  // Calls task(status, context) in its turn: with OK, or with the reason why it must not do its work, because nobody
  // waits for the answer any more (CANCELLED, DEADLINE_EXCEEDED), because its site is being deleted
  // (FAILED_PRECONDITION) or, from this thread, because too many calls wait (RESOURCE_EXHAUSTED). Quotas belong here.
  template <typename Task>
  void Run(CallLane lane, Task task) const {
    RunWith(context_, lane, task);
  }
  // The same with StepContext().
  template <typename Task>
  void RunStep(CallLane lane, Task task) const {
    RunWith(StepContext(), lane, task);
  }
  // Queues the next step of a stream that has begun, however many calls wait.
  void Continue(std::function<void()> step) const { environment_.executor.PostNext(std::move(step)); }

  // The same for making messages of a stream that the server sends.
  void ContinueBulk(std::function<void()> step) const { ExecutorOf(CallLane::kBulk).PostNext(std::move(step)); }
  // The same for a watch.
  void ContinueWatch(std::function<void()> step) const {
    (environment_.watches != nullptr ? *environment_.watches : environment_.executor).PostNext(std::move(step));
  }

  // Counts the call, and logs it if it failed. Call it once, right before the client gets the status.
  void Finish(const absl::Status& status) const;

 private:
  template <typename Task>
  void RunWith(const storage::CallContext& context, CallLane lane, Task task) const {
    const auto run = [this, task, context] { task(CheckAdmitted(context), context); };
    if (!ExecutorOf(lane).Post(run)) task(TooManyCalls(), context);
  }
  Executor& ExecutorOf(CallLane lane) const;
  static absl::Status CheckAwaited(const storage::CallContext& context);
  absl::Status CheckAdmitted(const storage::CallContext& context) const;
  static absl::Status TooManyCalls();

  const CallEnvironment& environment_;
  const char* const rpc_;
  const std::string request_id_;
  const std::string peer_;
  const Principal principal_;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  const std::optional<std::chrono::steady_clock::time_point> client_deadline_;
  const std::vector<std::string> min_graph_versions_;
  std::stop_source cancellation_;
  const storage::CallContext context_;
  std::string site_;
};

// What a call waits for before its turn on the executor, such as a read that many calls share: calls next(status) once,
// from any thread, and does not wait itself. With an error the call ends. Null: nothing.
using BeforeCall = std::function<void(const Call& call, std::function<void(const absl::Status&)> next)>;

// How a call gets its turn.
struct CallTurn {
  BeforeCall before = nullptr;
  // Whether the call may be answered at once, without `before`. Null: it may.
  std::function<bool(const Call& call)> may_answer_now = nullptr;
  CallLane lane = CallLane::kUsual;
};

}  // namespace enfilade::server
