// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/driver/connection.h"

#include <libpq-fe.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "storage/postgres/driver/error.h"

namespace enfilade::storage::postgres {
namespace {

using std::chrono::steady_clock;

// How much longer than the deadline to wait: the server should give up the statement at the deadline and say so.
constexpr std::chrono::milliseconds kGrace{500};
// How long a statement may run on after its caller has cancelled the call.
constexpr std::chrono::milliseconds kCancellationCheck{50};
// When a request to cancel is repeated, twice as long each time: one that reaches the database between two statements
// cancels neither.
constexpr std::chrono::milliseconds kCancelAgain{1000};
constexpr int kMostDoublings = 3;
constexpr char kQueryCanceled[] = "57014";
constexpr std::size_t kCopySlice = 1 << 20;
constexpr int kOldestServer = 150000;

enum class PollOutcome { kReady, kTimeout, kError };

PollOutcome PollSocket(int socket, short events, steady_clock::time_point until) {
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - steady_clock::now()).count();
    pollfd entry{socket, events, 0};
    const int ready = poll(&entry, 1, static_cast<int>(std::clamp<std::int64_t>(left, 0, 60'000)));
    if (ready > 0) return PollOutcome::kReady;
    if (ready < 0 && errno != EINTR) return PollOutcome::kError;
    if (ready == 0 && left <= 0) return PollOutcome::kTimeout;
  }
}

// Whether an error makes the connection useless although the socket may still be open.
bool EndsConnection(const absl::Status& status) {
  const std::string sqlstate = SqlStateOf(status);
  return sqlstate.starts_with("57P") || sqlstate.starts_with("08") || sqlstate.starts_with("25P03") ||
         // A standby since a failover; a plan from before a migration.
         sqlstate == "25006" || sqlstate == "0A000" || sqlstate == "26000";
}

absl::Status AwaitConnected(pg_conn* connection, steady_clock::time_point deadline) {
  PostgresPollingStatusType next = PGRES_POLLING_WRITING;
  while (PQstatus(connection) != CONNECTION_BAD && next != PGRES_POLLING_FAILED) {
    if (next == PGRES_POLLING_OK) return absl::OkStatus();
    const short events = next == PGRES_POLLING_READING ? POLLIN : POLLOUT;
    if (PollSocket(PQsocket(connection), events, deadline) != PollOutcome::kReady) {
      return Unavailable("cannot connect to the database: no answer in time");
    }
    next = PQconnectPoll(connection);
  }
  return CannotConnect(connection);
}

}  // namespace

absl::StatusOr<std::unique_ptr<Connection>> Connection::Open(const std::string& url, const Host& host,
                                                             const std::string& application_name, Deadline deadline) {
  // Those before "dbname" are defaults that the URL may change; those behind it replace what the URL says.
  std::vector<const char*> keywords;
  std::vector<const char*> values;
  const auto set = [&](const char* keyword, const char* value) {
    keywords.push_back(keyword);
    values.push_back(value);
  };
  set("application_name", application_name.c_str());
  set("keepalives_idle", "15");
  set("keepalives_interval", "5");
  set("keepalives_count", "3");
  set("tcp_user_timeout", "15000");
  set("target_session_attrs", "read-write");
  set("dbname", url.c_str());
  set("client_encoding", "UTF8");
  if (host != Host{}) {
    set("host", host.host.c_str());
    set("hostaddr", host.hostaddr.c_str());
    set("port", host.port.c_str());
  }
  set(nullptr, nullptr);
  std::unique_ptr<Connection> opened(new Connection(PQconnectStartParams(keywords.data(), values.data(), 1)));
  pg_conn* connection = opened->connection_.get();
  if (!connection) return absl::ResourceExhaustedError("cannot connect to the database: out of memory");
  ENFILADE_RETURN_IF_ERROR(AwaitConnected(connection, deadline));
  if (PQserverVersion(connection) < kOldestServer) {
    return Unavailable("the database server is PostgreSQL {}, at least 15 is needed",
                       PQserverVersion(connection) / 10000);
  }
  PQsetnonblocking(connection, 1);
  PQsetNoticeProcessor(
      connection, [](void*, const char*) {}, nullptr);
  return opened;
}

Connection::~Connection() = default;

void Connection::Disconnect::operator()(pg_conn* connection) const { PQfinish(connection); }

absl::Status Connection::Broken(absl::Status status) {
  broken_ = true;
  return status;
}

bool Connection::broken() const { return broken_ || PQstatus(connection_.get()) != CONNECTION_OK; }

bool Connection::idle() const {
  return !broken() && !cancel_may_follow_ && queue_.empty() && PQtransactionStatus(connection_.get()) == PQTRANS_IDLE;
}

bool Connection::closed_by_server() {
  if (broken()) return true;
  if (PollSocket(PQsocket(connection_.get()), POLLIN, steady_clock::now()) == PollOutcome::kTimeout) return false;
  // An idle connection has something to read: a notice, or the end.
  if (!PQconsumeInput(connection_.get())) broken_ = true;
  return broken() || PollSocket(PQsocket(connection_.get()), POLLIN, steady_clock::now()) != PollOutcome::kTimeout;
}

absl::Status Connection::EnterPipeline() {
  if (broken()) return LostConnection(connection_.get(), "preparing a statement");
  if (PQpipelineStatus(connection_.get()) != PQ_PIPELINE_OFF || PQenterPipelineMode(connection_.get())) {
    return absl::OkStatus();
  }
  return Broken(LostConnection(connection_.get(), "entering pipeline mode"));
}

absl::Status Connection::LeavePipeline(std::string_view what) {
  if (broken()) return LostConnection(connection_.get(), what);
  if (PQpipelineStatus(connection_.get()) == PQ_PIPELINE_OFF || PQexitPipelineMode(connection_.get())) {
    return absl::OkStatus();
  }
  return Broken(LostConnection(connection_.get(), what));
}

void Connection::Queue(const Statement& statement, const Params& params) {
  if (queue_status_.ok()) queue_status_ = EnterPipeline();
  if (!queue_status_.ok()) return;
  const Params::Bound bound = params.Bind();
  auto [prepared, is_new] = prepared_.try_emplace(&statement);
  bool sent = true;
  if (is_new) {
    prepared->second = fmt::format("s{}", ++prepared_count_);
    sent = PQsendPrepare(connection_.get(), prepared->second.c_str(), statement.sql, params.size(), bound.types.data());
    queue_.push_back({Step::kPrepare, &statement});
  }
  sent = sent && PQsendQueryPrepared(connection_.get(), prepared->second.c_str(), params.size(), bound.values.data(),
                                     bound.lengths.data(), bound.formats.data(), 1);
  queue_.push_back({Step::kExecute, &statement});
  if (!sent) queue_status_ = Broken(LostConnection(connection_.get(), statement.what));
}

void Connection::QueueSetting(const char* name, const std::string& value) {
  static constexpr Statement kSetLocal{"setting a parameter of the transaction", "SET LOCAL"};
  if (queue_status_.ok()) queue_status_ = EnterPipeline();
  if (!queue_status_.ok()) return;
  const std::unique_ptr<char, decltype(&PQfreemem)> literal(
      PQescapeLiteral(connection_.get(), value.data(), value.size()), &PQfreemem);
  if (literal == nullptr) {
    queue_status_ = InvalidArgument("{} is not valid UTF-8", name);
    return;
  }
  const std::string sql = fmt::format("{} {} = {}", kSetLocal.sql, name, literal.get());
  queue_.push_back({Step::kExecute, &kSetLocal});
  if (!PQsendQueryParams(connection_.get(), sql.c_str(), 0, nullptr, nullptr, nullptr, nullptr, 1)) {
    queue_status_ = Broken(LostConnection(connection_.get(), kSetLocal.what));
  }
}

absl::StatusOr<std::vector<Result>> Connection::Flush(const CallContext& context) {
  std::vector<Queued> queue = std::exchange(queue_, {});
  absl::Status status = std::exchange(queue_status_, absl::OkStatus());
  if (status.ok()) status = EnterPipeline();
  ENFILADE_RETURN_IF_ERROR(status);
  const char* what = queue.empty() ? "querying the database" : queue.back().statement->what;
  if (!PQpipelineSync(connection_.get())) return Broken(LostConnection(connection_.get(), what));
  std::vector<Result> results;
  for (const Queued& queued : queue) {
    const absl::Status taken = TakeResult(queued, context, results);
    if (status.ok()) status = taken;
    if (broken()) return status;
  }
  ENFILADE_RETURN_IF_ERROR(AwaitResult(context, what));
  const Result sync(PQgetResult(connection_.get()));
  if (PQresultStatus(sync.get()) != PGRES_PIPELINE_SYNC) return Broken(LostConnection(connection_.get(), what));
  if (EndsConnection(status)) broken_ = true;
  status = NameCancellation(std::move(status), context);
  if (!status.ok()) {
    statement_timeout_ms_ = 0;
    return status;
  }
  return results;
}

absl::Status Connection::TakeResult(const Queued& queued, const CallContext& context, std::vector<Result>& results) {
  const char* what = queued.statement->what;
  ENFILADE_RETURN_IF_ERROR(AwaitResult(context, what));
  Result result(PQgetResult(connection_.get()));
  ENFILADE_RETURN_IF_ERROR(AwaitResult(context, what));
  const Result end(PQgetResult(connection_.get()));  // null: the statement has no further result
  if (end.get()) return Broken(Internal("{}: an unexpected second result", what));
  const ExecStatusType outcome = PQresultStatus(result.get());
  if (outcome == PGRES_COMMAND_OK || outcome == PGRES_TUPLES_OK) {
    if (queued.step == Step::kExecute) results.push_back(std::move(result));
    return absl::OkStatus();
  }
  if (queued.step == Step::kPrepare) prepared_.erase(queued.statement);
  if (outcome == PGRES_PIPELINE_ABORTED) return Internal("{}: not executed after an earlier error", what);
  absl::Status status = StatusFromResult(result.get(), what);
  if (PQstatus(connection_.get()) != CONNECTION_OK) broken_ = true;
  return status;
}

absl::Status Connection::Wait(bool for_writing, const CallContext& context, std::string_view what) {
  const auto events = static_cast<short>(for_writing ? POLLIN | POLLOUT : POLLIN);
  const auto until = context.deadline + kGrace;
  while (true) {
    if (context.cancellation.stop_requested() && steady_clock::now() >= next_cancel_) CancelStatement();
    const bool may_cancel = context.cancellation.stop_possible();
    const auto next = may_cancel ? std::min(until, steady_clock::now() + kCancellationCheck) : until;
    switch (PollSocket(PQsocket(connection_.get()), events, next)) {
      case PollOutcome::kReady:
        return absl::OkStatus();
      case PollOutcome::kTimeout:
        if (next < until) break;
        return Broken(absl::DeadlineExceededError(fmt::format("{}: no answer from the database in time", what)));
      case PollOutcome::kError:
        return Broken(LostConnection(connection_.get(), what));
    }
  }
}

// Called by the waiting thread. Opens another connection for the request.
void Connection::CancelStatement() {
  next_cancel_ = steady_clock::now() + kCancelAgain * (1 << std::min(cancels_sent_, kMostDoublings));
  ++cancels_sent_;
  PGcancel* const cancel = PQgetCancel(connection_.get());
  if (!cancel) return;
  std::array<char, 256> error{};
  PQcancel(cancel, error.data(), static_cast<int>(error.size()));
  PQfreeCancel(cancel);
}

absl::Status Connection::NameCancellation(absl::Status status, const CallContext& context) {
  const bool was_cancelled = SqlStateOf(status) == kQueryCanceled;
  // A request that came too late for its statement might cancel the next one.
  if (cancels_sent_ > (was_cancelled ? 1 : 0)) cancel_may_follow_ = true;
  cancels_sent_ = 0;
  next_cancel_ = {};
  if (!was_cancelled || !context.cancellation.stop_requested() || steady_clock::now() >= context.deadline) {
    return status;
  }
  return absl::CancelledError(status.message());
}

absl::Status Connection::AwaitResult(const CallContext& context, std::string_view what) {
  bool unsent = true;
  while (true) {
    if (unsent) {
      const int flushed = PQflush(connection_.get());
      if (flushed < 0) return Broken(LostConnection(connection_.get(), what));
      unsent = flushed == 1;
    }
    if (!PQisBusy(connection_.get())) return absl::OkStatus();
    ENFILADE_RETURN_IF_ERROR(Wait(unsent, context, what));
    if (!PQconsumeInput(connection_.get())) return Broken(LostConnection(connection_.get(), what));
  }
}

absl::Status Connection::SendAll(const CallContext& context, std::string_view what) {
  while (true) {
    const int flushed = PQflush(connection_.get());
    if (flushed == 0) return absl::OkStatus();
    if (flushed < 0) return Broken(LostConnection(connection_.get(), what));
    ENFILADE_RETURN_IF_ERROR(Wait(true, context, what));
    if (!PQconsumeInput(connection_.get())) return Broken(LostConnection(connection_.get(), what));
  }
}

absl::Status Connection::CopyIn(const Statement& statement, std::string_view data, const CallContext& context) {
  ENFILADE_RETURN_IF_ERROR(LeavePipeline(statement.what));
  if (!PQsendQuery(connection_.get(), statement.sql)) {
    return Broken(LostConnection(connection_.get(), statement.what));
  }
  ENFILADE_RETURN_IF_ERROR(AwaitResult(context, statement.what));
  const Result start(PQgetResult(connection_.get()));
  absl::Status status;
  if (PQresultStatus(start.get()) == PGRES_COPY_IN) {
    while (!data.empty()) {
      const std::string_view slice = data.substr(0, kCopySlice);
      data.remove_prefix(slice.size());
      if (PQputCopyData(connection_.get(), slice.data(), static_cast<int>(slice.size())) != 1) {
        return Broken(LostConnection(connection_.get(), statement.what));
      }
      ENFILADE_RETURN_IF_ERROR(SendAll(context, statement.what));
    }
    if (PQputCopyEnd(connection_.get(), nullptr) != 1) {
      return Broken(LostConnection(connection_.get(), statement.what));
    }
  } else {
    status = StatusFromResult(start.get(), statement.what);
  }
  const absl::Status finished = FinishCopy(statement, context);
  return NameCancellation(status.ok() ? finished : status, context);
}

absl::StatusOr<std::vector<std::string>> Connection::AwaitNotifications(Deadline deadline) {
  constexpr char kWhat[] = "waiting for notifications";
  std::vector<std::string> payloads;
  while (true) {
    if (broken() || !PQconsumeInput(connection_.get())) return Broken(LostConnection(connection_.get(), kWhat));
    while (pgNotify* notification = PQnotifies(connection_.get())) {
      payloads.emplace_back(notification->extra);
      PQfreemem(notification);
    }
    if (!payloads.empty()) return payloads;
    switch (PollSocket(PQsocket(connection_.get()), POLLIN, deadline)) {
      case PollOutcome::kReady:
        break;
      case PollOutcome::kTimeout:
        return payloads;
      case PollOutcome::kError:
        return Broken(LostConnection(connection_.get(), kWhat));
    }
  }
}

absl::Status Connection::FinishCopy(const Statement& statement, const CallContext& context) {
  absl::Status status;
  while (true) {
    ENFILADE_RETURN_IF_ERROR(AwaitResult(context, statement.what));
    const Result result(PQgetResult(connection_.get()));
    if (!result.get()) break;
    if (PQresultStatus(result.get()) != PGRES_COMMAND_OK && status.ok()) {
      status = StatusFromResult(result.get(), statement.what);
    }
  }
  if (EndsConnection(status)) broken_ = true;
  return status;
}

}  // namespace enfilade::storage::postgres
