// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "client/sdk/spool/spool.h"
#include "client/sources/log_reader.h"

namespace enfilade::cli {

// Appends a log's entries to a spool, as fast as possible or at the recorded pace. A spool that already has the first
// entries, from an interrupted run, gets only the rest. Not thread-safe.
class LogFeeder {
 public:
  using Clock = std::chrono::steady_clock;

  struct Options {
    // 1: as recorded; 2: twice as fast; unset: as fast as the spool takes them.
    std::optional<double> rate;
    std::size_t max_batch = 256;               // entries in one append
    std::int64_t max_batch_bytes = 4LL << 20;  // contents of images and clouds in one append
  };

  // `spool` has the session and must outlive the feeder.
  LogFeeder(sources::LogReader reader, client::Spool& spool, SessionId session, const Options& options);

  // Skips the entries that the spool already has. FAILED_PRECONDITION: the log has fewer.
  absl::Status SkipSpooled();

  // Appends what is due at `now`, as far as the spool has room; false when all of the log is appended.
  // RESOURCE_EXHAUSTED: even the empty spool has no room for an entry.
  absl::StatusOr<bool> Feed(Clock::time_point now);
  // When the next entry is due.
  Clock::time_point next_due(Clock::time_point now) const;
  // The spool was full at the last Feed.
  bool spool_is_full() const { return spool_is_full_; }

  const sources::LogCounts& counts() const { return reader_.counts(); }

 private:
  absl::Status Gather(Clock::time_point now);
  absl::Status ReadNext();
  absl::Status AppendGathered();

  sources::LogReader reader_;
  client::Spool& spool_;
  SessionId session_;
  Options options_;
  std::optional<sources::LogEntry> next_;  // read, not yet gathered
  bool at_end_ = false;
  std::vector<client::SpoolItem> gathered_;
  bool spool_is_full_ = false;
  // Pace: the entry recorded at first_time_ was due at start_.
  std::optional<TimeNs> first_time_;
  Clock::time_point start_;
};

}  // namespace enfilade::cli
