// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <zlib.h>

#include <fstream>
#include <string>
#include <vector>

#include "client/sources/log_reader.h"
#include "tests/support/test_data.h"

namespace enfilade::testing {

// Writes log files into a directory of its own.
class LogFiles {
 public:
  std::filesystem::path Write(const std::string& name, const std::string& text) const {
    const std::filesystem::path path = directory_.path() / name;
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }
  std::filesystem::path WriteGz(const std::string& name, const std::string& text) const {
    const std::filesystem::path path = directory_.path() / name;
    gzFile file = gzopen(path.c_str(), "wb");
    gzwrite(file, text.data(), static_cast<unsigned>(text.size()));
    gzclose(file);
    return path;
  }
  const std::filesystem::path& path() const { return directory_.path(); }

 private:
  TemporaryDirectory directory_;
};

inline std::string Contents(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

struct ReadLog {
  std::vector<sources::LogEntry> entries;
  sources::LogFacts facts;
  sources::LogCounts counts;
  absl::Status status;  // what ended the reading
};

// Reads until the end or the first error.
inline ReadLog ReadAll(const std::filesystem::path& path, const sources::LogOptions& options = {}) {
  ReadLog result;
  absl::StatusOr<sources::LogReader> reader = sources::LogReader::Open(path, options);
  if (!reader.ok()) {
    result.status = reader.status();
    return result;
  }
  while (true) {
    absl::StatusOr<std::optional<sources::LogEntry>> entry = reader->Next();
    result.status = entry.status();
    if (!entry.ok() || !entry->has_value()) break;
    result.entries.push_back(**std::move(entry));
  }
  result.facts = reader->facts();
  result.counts = reader->counts();
  return result;
}

template <typename T>
std::vector<T> AllOf(const ReadLog& log) {
  std::vector<T> result;
  for (const sources::LogEntry& entry : log.entries) {
    if (const T* payload = std::get_if<T>(&entry.payload)) result.push_back(*payload);
  }
  return result;
}

// A FLASER line with these ranges; `times` are its ipc and logger times.
inline std::string FlaserLine(const std::vector<std::string>& ranges, const std::string& ipc_time,
                              const std::string& logger_time) {
  std::string line = "FLASER " + std::to_string(ranges.size());
  for (const std::string& range : ranges) line += " " + range;
  return line + " 0 0 0 1 2 0.5 " + ipc_time + " host " + logger_time + "\n";
}

}  // namespace enfilade::testing
