// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "storage/call_context.h"
#include "storage/postgres/driver/connection.h"
#include "storage/postgres/driver/pool.h"

namespace enfilade::storage::postgres {

// BEGIN ... COMMIT on a connection of the pool, with the database's statement_timeout set to the time that remains
// until the deadline (rounded down by at most 5 %), and the audit trail's actor. The context's cancellation cancels the
// running statement.
//
// Rolled back if it is destroyed without a commit. Costs no additional round trip: BEGIN goes with the first statement,
// and queued statements go with the next one or the commit. Not thread-safe.
class Transaction {
 public:
  static absl::StatusOr<Transaction> Begin(Pool& pool, const CallContext& context);
  ~Transaction();
  Transaction(Transaction&&) = default;
  Transaction& operator=(Transaction&&) = delete;

  // Executed with the next Flush, Execute, CopyIn or Commit, which returns its error.
  void Queue(const Statement& statement, const Params& params);
  // As Connection::QueueSetting; its place in the queue has an empty result.
  void QueueSetting(const char* name, const std::string& value);
  // Sends the notification with the commit: its listeners hear of what is committed only. Not from a trigger, as a
  // trigger of a sharded database runs, and notifies, on another node.
  void NotifyAtCommit(const char* channel, std::string payload);
  // Executes the queue in one round trip and returns its rows in that order. After an error only the destructor may
  // follow.
  absl::StatusOr<std::vector<Result>> Flush();
  // Queue and Flush; only this statement's rows.
  absl::StatusOr<Result> Execute(const Statement& statement, const Params& params);
  absl::Status CopyIn(const Statement& statement, std::string_view data);
  // UNAVAILABLE if the connection was lost: then nobody knows whether it was committed.
  absl::Status Commit();
  // The same, with the rows of the queue.
  absl::StatusOr<std::vector<Result>> FlushAndCommit();

 private:
  struct Notification {
    const char* channel;
    std::string payload;
  };

  Transaction(Pool::Lease lease, const CallContext& context);
  void QueueBegin();

  Pool::Lease lease_;
  CallContext context_;
  bool open_ = false;  // BEGIN was sent and neither COMMIT nor ROLLBACK
  bool failed_ = false;
  std::vector<Notification> notifications_;
  int queued_ = 0;  // the caller's statements that wait for the flush
};

// One statement as one transaction in one round trip; its timeout is the time that remains until the deadline. For
// statements that write: UNAVAILABLE means that nobody knows whether it was committed.
absl::StatusOr<Result> ExecuteAlone(Pool& pool, const CallContext& context, const Statement& statement,
                                    const Params& params);

}  // namespace enfilade::storage::postgres
