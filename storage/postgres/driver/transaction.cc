// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/driver/transaction.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/status_macros.h"

namespace enfilade::storage::postgres {
namespace {

using std::chrono::steady_clock;

constexpr Statement kBegin{"beginning a transaction", "BEGIN"};
constexpr Statement kCommit{"committing", "COMMIT"};
constexpr Statement kRollback{"rolling back", "ROLLBACK"};
constexpr Statement kSetTimeout{"setting the statement timeout", "SELECT set_config('statement_timeout', $1, false)"};
constexpr Statement kNotify{"announcing the change", "SELECT pg_notify($1, $2)"};
constexpr std::chrono::seconds kRollbackTime{2};

// The time that remains, rounded down by at most 5 %, so that calls of about the same deadline have the same timeout.
// In milliseconds; at least 1, because 0 means no timeout.
std::int64_t TimeoutMs(Connection::Deadline deadline) {
  constexpr double kStep = 1.05;
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - steady_clock::now()).count();
  const auto bounded = static_cast<double>(std::clamp<std::int64_t>(left, 1, 2'000'000'000));
  return static_cast<std::int64_t>(std::pow(kStep, std::floor(std::log(bounded) / std::log(kStep))));
}

// Does nothing if the connection has this timeout: setting it costs about a tenth of a small query.
void QueueTimeout(Connection& connection, Connection::Deadline deadline) {
  const std::int64_t timeout = TimeoutMs(deadline);
  if (connection.statement_timeout_ms() == timeout) return;
  connection.Queue(kSetTimeout, Params(std::to_string(timeout)));
  connection.set_statement_timeout_ms(timeout);
}

// For the setting of the actor, which lasts until the end of a transaction.
absl::StatusOr<Result> ExecuteInTransaction(Pool& pool, const CallContext& context, const Statement& statement,
                                            const Params& params) {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool, context));
  transaction.Queue(statement, params);
  ENFILADE_ASSIGN_OR_RETURN(std::vector<Result> results, transaction.FlushAndCommit());
  return std::move(results.back());
}

}  // namespace

absl::StatusOr<Transaction> Transaction::Begin(Pool& pool, const CallContext& context) {
  ENFILADE_ASSIGN_OR_RETURN(Pool::Lease lease, pool.Acquire(context));
  return Transaction(std::move(lease), context);
}

Transaction::Transaction(Pool::Lease lease, const CallContext& context) : lease_(std::move(lease)), context_(context) {}

Transaction::~Transaction() {
  if (!lease_ || !open_ || lease_->broken()) return;
  lease_->set_statement_timeout_ms(0);
  lease_->Queue(kRollback, Params());
  // If this fails, the pool closes the connection, which rolls back as well.
  lease_->Flush(CallContext::WithTimeout(kRollbackTime)).IgnoreError();
}

void Transaction::QueueBegin() {
  lease_->Queue(kBegin, Params());
  QueueTimeout(*lease_, context_.deadline);
  if (!context_.actor.empty()) lease_->QueueSetting("enfilade.actor", context_.actor);
  open_ = true;
}

void Transaction::Queue(const Statement& statement, const Params& params) {
  if (!open_) QueueBegin();
  lease_->Queue(statement, params);
  ++queued_;
}

void Transaction::QueueSetting(const char* name, const std::string& value) {
  if (!open_) QueueBegin();
  lease_->QueueSetting(name, value);
  ++queued_;
}

void Transaction::NotifyAtCommit(const char* channel, std::string payload) {
  notifications_.push_back({channel, std::move(payload)});
}

absl::StatusOr<std::vector<Result>> Transaction::Flush() {
  const int queued = std::exchange(queued_, 0);
  auto results = lease_->Flush(context_);
  failed_ = failed_ || !results.ok();
  if (results.ok()) results->erase(results->begin(), results->end() - queued);  // those of BEGIN and its settings
  return results;
}

absl::StatusOr<Result> Transaction::Execute(const Statement& statement, const Params& params) {
  Queue(statement, params);
  ENFILADE_ASSIGN_OR_RETURN(std::vector<Result> results, Flush());
  return std::move(results.back());
}

absl::Status Transaction::CopyIn(const Statement& statement, std::string_view data) {
  const bool begins = !open_;
  if (begins) QueueBegin();
  if (begins || queued_ > 0) ENFILADE_RETURN_IF_ERROR(Flush().status());
  absl::Status copied = lease_->CopyIn(statement, data, context_);
  failed_ = failed_ || !copied.ok();
  return copied;
}

absl::Status Transaction::Commit() { return FlushAndCommit().status(); }

absl::StatusOr<std::vector<Result>> Transaction::FlushAndCommit() {
  if (!open_) return std::vector<Result>();
  // PostgreSQL would answer the commit of a failed transaction by a rollback, without an error.
  if (failed_) return absl::InternalError("a failed transaction cannot be committed");
  const std::size_t wanted = static_cast<std::size_t>(queued_);
  for (const Notification& sent : notifications_) Queue(kNotify, Params(std::string_view(sent.channel), sent.payload));
  lease_->Queue(kCommit, Params());
  ++queued_;
  ENFILADE_ASSIGN_OR_RETURN(std::vector<Result> results, Flush());
  open_ = false;
  results.erase(results.begin() + static_cast<std::ptrdiff_t>(wanted), results.end());
  return results;
}

absl::StatusOr<Result> ExecuteAlone(Pool& pool, const CallContext& context, const Statement& statement,
                                    const Params& params) {
  if (!context.actor.empty()) return ExecuteInTransaction(pool, context, statement, params);
  ENFILADE_ASSIGN_OR_RETURN(Pool::Lease lease, pool.Acquire(context));
  QueueTimeout(*lease, context.deadline);
  lease->Queue(statement, params);
  ENFILADE_ASSIGN_OR_RETURN(std::vector<Result> results, lease->Flush(context));
  return std::move(results.back());
}

}  // namespace enfilade::storage::postgres
