// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "client/sources/log_reader.h"

namespace enfilade::sources {

// What one line came to.
struct ParsedLine {
  std::vector<LogEntry> entries;
  std::string skipped_tag;  // set where the line is of a kind that carries nothing for us
};

// One format. Lines come without their end, comments and empty lines not at all.
class LogParser {
 public:
  virtual ~LogParser() = default;

  // First pass, every line in order. What cannot be read is passed over: the second pass reports it.
  virtual void Survey(std::string_view line) = 0;
  // Between the passes: fills in what the survey found.
  virtual void Conclude(LogFacts& facts) = 0;
  // Second pass. INVALID_ARGUMENT naming the field.
  virtual absl::StatusOr<ParsedLine> Parse(std::string_view line) = 0;
};

std::unique_ptr<LogParser> NewCarmenParser(const LogOptions& options);
std::unique_ptr<LogParser> NewWeanHallParser(const LogOptions& options);
std::unique_ptr<LogParser> NewMinesParisParser(const LogOptions& options);
// `folder`: what the paths of images and clouds in the log are relative to.
std::unique_ptr<LogParser> NewJsonLinesParser(const LogOptions& options, const std::filesystem::path& folder);

// Readings below this are no measurement with any scanner of these logs, m.
constexpr float kRangeMin = 0.02F;

}  // namespace enfilade::sources
