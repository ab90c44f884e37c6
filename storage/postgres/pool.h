#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "storage/call_context.h"

namespace enfilade::postgres {

class Connection;

struct PoolOptions {
  // A URL ("postgresql://user@host:5432/enfilade", "postgresql:///enfilade?host=/run/dir") or a libpq keyword string.
  std::string url;
  int max_connections = 16;
  // How long one attempt to connect may take.
  std::chrono::milliseconds connect_timeout{5000};
  // A connection that lay idle for longer is tried with a query before it is given out.
  std::chrono::milliseconds check_idle_after{10'000};
  // After a failed attempt to connect no other is made for this time, doubled with each failure up to the maximum.
  std::chrono::milliseconds first_backoff{50};
  std::chrono::milliseconds max_backoff{2000};
  std::string application_name = "enfilade";

  // INVALID_ARGUMENT naming the option.
  absl::Status Validate() const;
};

// Connections to one database, opened when needed and kept. Thread-safe. Must outlive all leases and stores on it.
class Pool {
 public:
  // Connects to nothing yet. INVALID_ARGUMENT where the options or the URL are malformed.
  static absl::StatusOr<std::unique_ptr<Pool>> Create(PoolOptions options);
  ~Pool();
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  // A connection for exclusive use; it goes back into the pool with the lease, or is closed where it broke.
  class Lease;
  // UNAVAILABLE at once where the server cannot be reached (or could not a moment ago: back-off), with its reason;
  // DEADLINE_EXCEEDED where all connections stay busy until the deadline.
  absl::StatusOr<Lease> Acquire(const CallContext& context);

  // One round trip to the database. OK, UNAVAILABLE or DEADLINE_EXCEEDED.
  absl::Status Ping(const CallContext& context);

  struct Stats {
    int open = 0;
    int busy = 0;
    int waiting = 0;            // callers in Acquire
    std::int64_t opened = 0;    // since the start
    std::int64_t failures = 0;  // to open
  };
  Stats stats() const;

 private:
  class Impl;
  explicit Pool(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::postgres
