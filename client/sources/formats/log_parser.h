// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "client/sources/log_reader.h"

namespace enfilade::sources {

// What one line contains.
struct ParsedLine {
  std::vector<LogEntry> entries;
  std::string skipped_tag;  // set if the line is of a kind that is not used
};

// The parser of one format. It gets lines without their ends, and neither comments nor empty lines.
class LogParser {
 public:
  virtual ~LogParser() = default;

  // First pass, every line in order. Lines that cannot be read are ignored: the second pass reports them.
  virtual void Survey(std::string_view line) = 0;
  // Between the passes: fills in the results of the survey.
  virtual void Conclude(LogFacts& facts) = 0;
  // Second pass. INVALID_ARGUMENT naming the field.
  virtual absl::StatusOr<ParsedLine> Parse(std::string_view line) = 0;
};

std::unique_ptr<LogParser> NewCarmenParser(const LogOptions& options);
std::unique_ptr<LogParser> NewWeanHallParser(const LogOptions& options);
std::unique_ptr<LogParser> NewMinesParisParser(const LogOptions& options);
// `folder`: the paths of images and clouds in the log are relative to it.
std::unique_ptr<LogParser> NewJsonLinesParser(const LogOptions& options, const std::filesystem::path& folder);

// m: readings below this are not measurements, with any scanner of these logs.
constexpr float kRangeMin = 0.02F;

}  // namespace enfilade::sources
