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

// Puts a log's entries into a spool, all at once or at the pace at which they were recorded. A spool that already holds
// the first entries (of a run that was broken off) gets the rest only. Not thread-safe.
class LogFeeder {
 public:
  using Clock = std::chrono::steady_clock;

  struct Options {
    // 1: as recorded; 2: twice as fast; unset: as fast as the spool takes them.
    std::optional<double> rate;
    std::size_t max_batch = 256;               // entries in one append
    std::int64_t max_batch_bytes = 4LL << 20;  // contents of images and clouds in one append
  };

  // `spool` holds the session and must outlive the feeder.
  LogFeeder(sources::LogReader reader, client::Spool& spool, SessionId session, const Options& options);

  // Passes over the entries that the spool holds already. FAILED_PRECONDITION where the log ends before that.
  absl::Status SkipSpooled();

  // Appends what is due at `now`, or as much of it as the spool has room for; false when all of the log is appended.
  // RESOURCE_EXHAUSTED where even the empty spool has no room for an entry.
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
