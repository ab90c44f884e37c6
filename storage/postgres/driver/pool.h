// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "storage/call_context.h"
#include "storage/postgres/driver/host_list.h"

namespace enfilade::storage::postgres {

class Connection;

struct PoolOptions {
  // A URL ("postgresql://user@host:5432/enfilade", "postgresql:///enfilade?host=/run/dir") or a libpq keyword string.
  std::string url;
  int max_connections = 16;
  // How long one attempt to connect may take.
  std::chrono::milliseconds connect_timeout{5000};
  // A connection that was idle for longer is checked by a query before it is handed out.
  std::chrono::milliseconds check_idle_after{10'000};
  // After a failed attempt to connect there is no other for this time, doubled with each failure up to the maximum.
  std::chrono::milliseconds first_backoff{50};
  std::chrono::milliseconds max_backoff{2000};
  std::string application_name = "enfilade";

  // INVALID_ARGUMENT naming the option.
  absl::Status Validate() const;
};

// Connections to one database, opened when needed and kept. Thread-safe. Must outlive all leases and stores on it.
class Pool {
 public:
  // Connects to nothing yet. INVALID_ARGUMENT if the options or the URL are malformed.
  static absl::StatusOr<std::unique_ptr<Pool>> Create(PoolOptions options);
  ~Pool();
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  // A connection for exclusive use; the lease gives it back to the pool, or closes it if it is broken.
  class Lease {
   public:
    ~Lease();
    Lease(Lease&&) noexcept;
    Lease& operator=(Lease&&) = delete;

    explicit operator bool() const { return connection_ != nullptr; }
    Connection* operator->() const { return connection_.get(); }
    Connection& operator*() const { return *connection_; }

   private:
    friend class Pool;
    Lease(Pool* pool, std::unique_ptr<Connection> connection);

    Pool* pool_;
    std::unique_ptr<Connection> connection_;
  };
  // UNAVAILABLE with the reason, without waiting, if the server cannot be reached or could not a moment ago (back-off);
  // DEADLINE_EXCEEDED if all connections stay busy until the deadline; CANCELLED with the caller's call.
  absl::StatusOr<Lease> Acquire(const CallContext& context);

  struct Stats {
    int open = 0;
    int busy = 0;
    int waiting = 0;            // callers in Acquire
    std::int64_t opened = 0;    // since the start
    std::int64_t failures = 0;  // to open
  };
  Stats stats() const;

 private:
  struct Idle {
    std::unique_ptr<Connection> connection;
    std::chrono::steady_clock::time_point since;
  };

  explicit Pool(PoolOptions options);

  // What an Acquire does next.
  struct Take {
    std::unique_ptr<Connection> idle;  // to be used if it is alive
    bool check = false;                // by a query
  };
  // An idle connection, or the right to open one, which then already counts as open.
  absl::StatusOr<Take> TakeOrWait(const CallContext& context);
  absl::StatusOr<std::unique_ptr<Connection>> Open(const CallContext& context);
  void GiveBack(std::unique_ptr<Connection> connection);
  void Forget();

  const PoolOptions options_;
  HostList hosts_;
  mutable Mutex mutex_;
  CondVar freed_;
  std::vector<Idle> idle_ ABSL_GUARDED_BY(mutex_);  // the last one was used last
  Stats stats_ ABSL_GUARDED_BY(mutex_);
  std::chrono::milliseconds backoff_ ABSL_GUARDED_BY(mutex_){0};
  std::chrono::steady_clock::time_point next_attempt_ ABSL_GUARDED_BY(mutex_);
  absl::Status last_failure_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace enfilade::storage::postgres
