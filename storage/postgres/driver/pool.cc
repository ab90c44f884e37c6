// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/driver/pool.h"

#include <libpq-fe.h>

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "storage/postgres/driver/connection.h"

namespace enfilade::storage::postgres {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

// How soon a caller that waits for a connection notices that its call was cancelled.
constexpr milliseconds kWaitCancellationCheck{50};

absl::Status ValidateUrl(const std::string& url) {
  char* error = nullptr;
  PQconninfoOption* parsed = PQconninfoParse(url.c_str(), &error);
  if (parsed) {
    PQconninfoFree(parsed);
    return absl::OkStatus();
  }
  std::string reason = error ? error : "out of memory";
  PQfreemem(error);
  while (!reason.empty() && reason.back() == '\n') reason.pop_back();
  return InvalidArgument("database url is malformed: {}", reason);
}

}  // namespace

absl::Status PoolOptions::Validate() const {
  if (url.empty()) return InvalidArgument("database url is empty");
  ENFILADE_RETURN_IF_ERROR(ValidateUrl(url));
  if (max_connections < 1) return InvalidArgument("max_connections is {}: at least 1 is needed", max_connections);
  if (connect_timeout <= milliseconds(0)) return InvalidArgument("connect_timeout must be positive");
  if (check_idle_after < milliseconds(0)) return InvalidArgument("check_idle_after must not be negative");
  if (first_backoff <= milliseconds(0)) return InvalidArgument("first_backoff must be positive");
  if (max_backoff < first_backoff) return InvalidArgument("max_backoff must not be below first_backoff");
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<Pool>> Pool::Create(PoolOptions options) {
  ENFILADE_RETURN_IF_ERROR(options.Validate());
  return std::unique_ptr<Pool>(new Pool(std::move(options)));
}

Pool::Pool(PoolOptions options) : options_(std::move(options)), hosts_(options_.url) {}
Pool::~Pool() = default;

Pool::Lease::Lease(Pool* pool, std::unique_ptr<Connection> connection)
    : pool_(pool), connection_(std::move(connection)) {}
Pool::Lease::Lease(Lease&&) noexcept = default;
Pool::Lease::~Lease() {
  if (connection_) pool_->GiveBack(std::move(connection_));
}

absl::StatusOr<Pool::Lease> Pool::Acquire(const CallContext& context) {
  if (steady_clock::now() >= context.deadline)
    return absl::DeadlineExceededError("the deadline of the call has passed");
  while (true) {
    ENFILADE_ASSIGN_OR_RETURN(Take take, TakeOrWait(context));
    if (!take.idle) {
      ENFILADE_ASSIGN_OR_RETURN(std::unique_ptr<Connection> opened, Open(context));
      return Lease(this, std::move(opened));
    }
    // An empty flush asks for an answer without a statement.
    const bool dead = take.idle->closed_by_server() || (take.check && !take.idle->Flush(context).ok());
    if (!dead) return Lease(this, std::move(take.idle));
    take.idle.reset();
    Forget();
  }
}

absl::StatusOr<Pool::Take> Pool::TakeOrWait(const CallContext& context) {
  const MutexLock lock(mutex_);
  while (true) {
    if (context.cancellation.stop_requested()) return absl::CancelledError("the caller has cancelled the call");
    if (!idle_.empty()) {
      Idle idle = std::move(idle_.back());
      idle_.pop_back();
      ++stats_.busy;
      return Take{std::move(idle.connection), steady_clock::now() - idle.since > options_.check_idle_after};
    }
    if (stats_.open < options_.max_connections) {
      if (steady_clock::now() < next_attempt_) return last_failure_;
      ++stats_.open;
      ++stats_.busy;
      return Take{};
    }
    ++stats_.waiting;
    freed_.WaitUntil(mutex_, context.cancellation.stop_possible()
                                 ? std::min(context.deadline, steady_clock::now() + kWaitCancellationCheck)
                                 : context.deadline);
    --stats_.waiting;
    if (idle_.empty() && stats_.open >= options_.max_connections && steady_clock::now() >= context.deadline) {
      return absl::DeadlineExceededError(
          fmt::format("all {} connections to the database stayed busy", options_.max_connections));
    }
  }
}

absl::StatusOr<std::unique_ptr<Connection>> Pool::Open(const CallContext& context) {
  const auto deadline = std::min(context.deadline, steady_clock::now() + options_.connect_timeout);
  auto opened = hosts_.Open(options_.application_name, deadline);
  const MutexLock lock(mutex_);
  if (opened.ok()) {
    ++stats_.opened;
    backoff_ = milliseconds(0);
    return opened;
  }
  --stats_.open;
  --stats_.busy;
  ++stats_.failures;
  freed_.NotifyOne();
  if (steady_clock::now() >= context.deadline) return opened;  // the failure may be for lack of time
  backoff_ = std::clamp(backoff_ * 2, options_.first_backoff, options_.max_backoff);
  next_attempt_ = steady_clock::now() + backoff_;
  last_failure_ = opened.status();
  return opened;
}

void Pool::GiveBack(std::unique_ptr<Connection> connection) {
  if (!connection->idle()) {
    connection.reset();
    return Forget();
  }
  const MutexLock lock(mutex_);
  --stats_.busy;
  idle_.push_back({std::move(connection), steady_clock::now()});
  freed_.NotifyOne();
}

// A connection was closed: another may be opened.
void Pool::Forget() {
  const MutexLock lock(mutex_);
  --stats_.open;
  --stats_.busy;
  freed_.NotifyOne();
}

Pool::Stats Pool::stats() const {
  const MutexLock lock(mutex_);
  return stats_;
}

}  // namespace enfilade::storage::postgres
