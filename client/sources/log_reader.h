// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/sources/line_source.h"
#include "core/sensor/record.h"

namespace enfilade::sources {

// One record of a robot; the caller assigns its sequence.
struct LogEntry {
  sensor::RecordPayload payload;
  std::filesystem::path content;  // of an image or point cloud: the file that holds its bytes

  friend bool operator==(const LogEntry&, const LogEntry&) = default;
};

enum class LogFormat { kCarmen, kWeanHall, kMinesParis, kJsonLines };
std::string ToString(LogFormat format);

struct LogOptions {
  std::optional<LogFormat> format;      // default: detected from the first line that is not a comment
  bool skip_bad_lines = false;          // count lines that cannot be read, and continue
  bool odometry = true;                 // false: scans only
  std::optional<double> range_max;      // m, instead of the range found in the log (docs/logs.md)
  std::optional<double> field_of_view;  // rad, of CARMEN FLASER and Wean Hall scans, instead of 180 degrees
};

// Properties of the whole log, known before its first entry is delivered.
struct LogFacts {
  LogFormat format = LogFormat::kCarmen;
  std::int64_t lines = 0;
  std::int64_t scans = 0;
  std::int64_t entries = 0;      // that Next delivers if no line is bad
  float range_max = 0.0F;        // m, if one applies to the whole log; otherwise 0
  std::string times;             // which times are used, as text
  bool synthetic_times = false;  // the log's own times were unusable
};

// Counts of what has been read so far.
struct LogCounts {
  std::int64_t lines = 0;
  std::int64_t scans = 0;
  std::int64_t odometry = 0;
  std::int64_t images = 0;
  std::int64_t point_clouds = 0;
  std::int64_t comments = 0;            // and empty lines
  std::int64_t bad_lines = 0;           // skipped by LogOptions::skip_bad_lines
  std::int64_t scans_back_in_time = 0;  // older than the scan before; delivered as they are
  std::int64_t odometry_back_in_time = 0;
  std::int64_t beams_no_return = 0;
  std::int64_t beams_unknown = 0;                     // NaN, negative, below range_min
  std::map<std::string, std::int64_t> skipped_lines;  // lines of other kinds, by their tag
};

class LogParser;

// Reads a recorded log (formats: docs/logs.md) and delivers its entries in the order of the lines. A file is read
// twice: Open surveys it (which times are usable, which range means "no return", how many entries), Next delivers.
//
// Errors name file, line and field. A line is delivered completely or not at all. Not thread-safe. Movable.
class LogReader {
 public:
  // NOT_FOUND: no such file. INVALID_ARGUMENT: a directory, an empty file, an unknown format.
  static absl::StatusOr<LogReader> Open(const std::filesystem::path& path, const LogOptions& options = {});
  ~LogReader();
  LogReader(LogReader&&) noexcept;
  LogReader& operator=(LogReader&&) noexcept;

  // The next entry, nullopt at the end. INVALID_ARGUMENT "file:line: ...": a line cannot be read (not with
  // skip_bad_lines); the next call continues after that line.
  absl::StatusOr<std::optional<LogEntry>> Next();

  const LogFacts& facts() const { return facts_; }
  const LogCounts& counts() const { return counts_; }

 private:
  LogReader(const LogOptions& options, LineSource lines, std::unique_ptr<LogParser> parser);
  absl::Status Survey();
  // Parses one line into pending_.
  absl::Status ReadLine(std::string_view line);
  absl::Status Accept(std::vector<LogEntry> entries);

  LogOptions options_;
  LineSource lines_;
  std::unique_ptr<LogParser> parser_;
  LogFacts facts_;
  LogCounts counts_;
  std::deque<LogEntry> pending_;
  TimeNs last_scan_time_;
  TimeNs last_odometry_time_;
};

}  // namespace enfilade::sources
