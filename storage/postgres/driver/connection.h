// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "storage/call_context.h"
#include "storage/postgres/driver/host_list.h"
#include "storage/postgres/driver/params.h"
#include "storage/postgres/driver/result.h"

struct pg_conn;

namespace enfilade::storage::postgres {

// One SQL statement: a constant at namespace scope beside its one user; each connection prepares it at its first use.
struct Statement {
  const char* what;  // what it does, for error messages: "storing the map"
  const char* sql;   // with $1, $2, ...
};

// One connection. Statements are queued and sent together: a flush is one round trip, however many they are. Not
// thread-safe; never blocks for longer than a deadline and a grace of half a second, in which the server's own timeout
// should have answered.
class Connection {
 public:
  using Deadline = std::chrono::steady_clock::time_point;

  // `host`: one of those that the URL names; a default one: as the URL says. UNAVAILABLE with the reason;
  // PERMISSION_DENIED; FAILED_PRECONDITION if the database does not exist or the server is too old.
  static absl::StatusOr<std::unique_ptr<Connection>> Open(const std::string& url, const Host& host,
                                                          const std::string& application_name, Deadline deadline);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  // The flush returns the errors.
  void Queue(const Statement& statement, const Params& params);
  // SET LOCAL: until the end of the transaction, which must have begun. Unlike set_config(), a sharded database carries
  // it to the nodes that the transaction reaches. Invalid UTF-8 is an error of the flush.
  void QueueSetting(const char* name, const std::string& value);

  // Sends what is queued and waits for all of it; the results come in the order of the queue. The error is that of the
  // first statement that failed; those after it were not executed.
  //
  // Outside BEGIN and COMMIT all of the queue is one transaction, committed with the flush.
  //
  // CANCELLED if the context's cancellation stopped a statement, which it does within a fraction of a second
  // (PQcancel), or a second and more if a request is lost. The connection remains usable if one request was enough.
  absl::StatusOr<std::vector<Result>> Flush(const CallContext& context);

  // COPY ... FROM STDIN (FORMAT binary) with the whole of `data` (see CopyBuffer). Nothing may be queued.
  absl::Status CopyIn(const Statement& statement, std::string_view data, const CallContext& context);

  // Payloads of notifications on the channels that this connection listens to. Waits for the first until the deadline,
  // and returns none then. Nothing may be queued. UNAVAILABLE if the connection is lost.
  absl::StatusOr<std::vector<std::string>> AwaitNotifications(Deadline deadline);
  // Keeps the connection out of the pool: it is closed instead.
  void Retire() { broken_ = true; }

  // The session's statement_timeout in ms as its users last set it; 0: unknown. A flush that fails resets it, as the
  // setting may have been rolled back.
  std::int64_t statement_timeout_ms() const { return statement_timeout_ms_; }
  void set_statement_timeout_ms(std::int64_t timeout) { statement_timeout_ms_ = timeout; }

  // It can only be destroyed.
  bool broken() const;
  // Outside any transaction, nothing queued, not broken: another caller may have it.
  bool idle() const;
  // Whether the server has closed an idle connection, as far as the socket shows.
  bool closed_by_server();

 private:
  struct Disconnect {
    void operator()(pg_conn* connection) const;
  };
  enum class Step { kPrepare, kExecute };
  struct Queued {
    Step step;
    const Statement* statement;
  };

  explicit Connection(pg_conn* connection) : connection_(connection) {}

  absl::Status EnterPipeline();
  absl::Status LeavePipeline(std::string_view what);
  // Waits until the next result can be taken without blocking.
  absl::Status AwaitResult(const CallContext& context, std::string_view what);
  absl::Status SendAll(const CallContext& context, std::string_view what);
  absl::Status Wait(bool for_writing, const CallContext& context, std::string_view what);
  absl::Status TakeResult(const Queued& queued, const CallContext& context, std::vector<Result>& results);
  absl::Status FinishCopy(const Statement& statement, const CallContext& context);
  // Asks the server to stop the running statement.
  void CancelStatement();
  // At the end of a flush or copy: CANCELLED if CancelStatement() made it fail.
  absl::Status NameCancellation(absl::Status status, const CallContext& context);
  absl::Status Broken(absl::Status status);

  std::unique_ptr<pg_conn, Disconnect> connection_;
  std::map<const Statement*, std::string> prepared_;
  std::int64_t prepared_count_ = 0;
  std::vector<Queued> queue_;
  absl::Status queue_status_;
  std::int64_t statement_timeout_ms_ = 0;
  int cancels_sent_ = 0;                                 // by the flush or copy under way
  std::chrono::steady_clock::time_point next_cancel_{};  // when the next request may be sent
  bool cancel_may_follow_ = false;  // more requests to cancel were sent than statements were cancelled
  bool broken_ = false;
};

}  // namespace enfilade::storage::postgres
