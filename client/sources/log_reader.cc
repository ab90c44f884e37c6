// SPDX-License-Identifier: Apache-2.0
#include "client/sources/log_reader.h"

#include <limits>
#include <utility>

#include "client/sources/formats/log_parser.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::sources {
namespace {

bool IsComment(std::string_view line) {
  const std::size_t first = line.find_first_not_of(" \t\f");
  return first == std::string_view::npos || line[first] == '#';
}

bool IsOneOf(std::string_view word, std::initializer_list<std::string_view> words) {
  for (const std::string_view candidate : words) {
    if (word == candidate) return true;
  }
  return false;
}

// `line`: the first one that is neither empty nor a comment.
std::optional<LogFormat> FormatOf(std::string_view line) {
  const std::string_view text = line.substr(line.find_first_not_of(" \t\f"));
  const std::string_view tag = text.substr(0, text.find_first_of(" \t\f"));
  if (text.front() == '{') return LogFormat::kJsonLines;
  if (IsOneOf(tag, {"O", "L"})) return LogFormat::kWeanHall;
  if (IsOneOf(tag,
              {"FLASER", "RLASER", "ODOM", "PARAM", "ROBOTLASER1", "ROBOTLASER2", "RAWLASER1", "RAWLASER2", "RAWLASER3",
               "RAWLASER4", "LASER3", "LASER4", "NEFF", "SYNC", "TRUEPOS", "VERTEX2", "EDGE2", "NMEAGGA", "IMU"})) {
    return LogFormat::kCarmen;
  }
  const bool numbers = text.find_first_not_of("0123456789.+- \t") == std::string_view::npos;
  constexpr int kLeastFields = 100;
  int fields = 0;
  for (std::size_t i = 0; i < text.size(); ++i) fields += text[i] == ' ' || text[i] == '\t';
  if (numbers && fields >= kLeastFields) return LogFormat::kMinesParis;
  return std::nullopt;
}

absl::StatusOr<LogFormat> DetectFormat(const std::filesystem::path& path) {
  ENFILADE_ASSIGN_OR_RETURN(LineSource lines, LineSource::Open(path));
  while (true) {
    ENFILADE_ASSIGN_OR_RETURN(const std::optional<std::string_view> line, lines.Next());
    if (!line) break;
    if (IsComment(*line)) continue;
    if (const std::optional<LogFormat> format = FormatOf(*line)) return *format;
    return InvalidArgument(
        "{}: unknown format (expected CARMEN, Wean Hall, Mines Paris or JSON lines): the line begins with \"{}\"",
        lines.Where(), line->substr(0, 40));
  }
  return InvalidArgument("{}: the log is empty: it has {} lines without data", path.string(), lines.line_number());
}

std::unique_ptr<LogParser> NewParser(LogFormat format, const LogOptions& options, const std::filesystem::path& path) {
  switch (format) {
    case LogFormat::kCarmen:
      return NewCarmenParser(options);
    case LogFormat::kWeanHall:
      return NewWeanHallParser(options);
    case LogFormat::kMinesParis:
      return NewMinesParisParser(options);
    case LogFormat::kJsonLines:
      return NewJsonLinesParser(options, path.parent_path());
  }
  return nullptr;
}

// A LineSource that cannot continue after an error does not advance its line number.
bool CanContinue(const LineSource& lines, std::int64_t line_before) { return lines.line_number() > line_before; }

}  // namespace

std::string ToString(LogFormat format) {
  switch (format) {
    case LogFormat::kCarmen:
      return "CARMEN";
    case LogFormat::kWeanHall:
      return "Wean Hall";
    case LogFormat::kMinesParis:
      return "Mines Paris";
    case LogFormat::kJsonLines:
      return "JSON lines";
  }
  return "?";
}

LogReader::LogReader(const LogOptions& options, LineSource lines, std::unique_ptr<LogParser> parser)
    : options_(options),
      lines_(std::move(lines)),
      parser_(std::move(parser)),
      last_scan_time_(std::numeric_limits<TimeNs>::min()),
      last_odometry_time_(std::numeric_limits<TimeNs>::min()) {}

LogReader::~LogReader() = default;
LogReader::LogReader(LogReader&&) noexcept = default;
LogReader& LogReader::operator=(LogReader&&) noexcept = default;

absl::StatusOr<LogReader> LogReader::Open(const std::filesystem::path& path, const LogOptions& options) {
  LogFormat format{};
  if (options.format) {
    format = *options.format;
  } else {
    ENFILADE_ASSIGN_OR_RETURN(format, DetectFormat(path));
  }
  ENFILADE_ASSIGN_OR_RETURN(LineSource lines, LineSource::Open(path));
  LogReader reader(options, std::move(lines), NewParser(format, options, path));
  reader.facts_.format = format;
  ENFILADE_RETURN_IF_ERROR(reader.Survey());
  return reader;
}

absl::Status LogReader::Survey() {
  ENFILADE_ASSIGN_OR_RETURN(LineSource lines, LineSource::Open(lines_.path()));
  while (true) {
    const std::int64_t before = lines.line_number();
    const auto line = lines.Next();
    if (!line.ok() && !CanContinue(lines, before)) break;  // the second pass reports it, after what can be read
    if (!line.ok()) continue;
    if (!line->has_value()) break;
    if (!IsComment(**line)) parser_->Survey(**line);
  }
  facts_.lines = lines.line_number();
  parser_->Conclude(facts_);
  return absl::OkStatus();
}

absl::StatusOr<std::optional<LogEntry>> LogReader::Next() {
  while (pending_.empty()) {
    const std::int64_t before = lines_.line_number();
    const auto line = lines_.Next();
    if (line.ok() && !line->has_value()) return std::nullopt;
    if (!line.ok() && !CanContinue(lines_, before)) return line.status();
    ++counts_.lines;
    const absl::Status status = line.ok() ? ReadLine(**line) : line.status();
    if (status.ok()) continue;
    if (!options_.skip_bad_lines) return status;
    ++counts_.bad_lines;
  }
  LogEntry entry = std::move(pending_.front());
  pending_.pop_front();
  return entry;
}

absl::Status LogReader::ReadLine(std::string_view line) {
  if (IsComment(line)) {
    ++counts_.comments;
    return absl::OkStatus();
  }
  absl::StatusOr<ParsedLine> parsed = parser_->Parse(line);
  if (!parsed.ok()) return WithContext(parsed.status(), lines_.Where());
  if (!parsed->skipped_tag.empty()) ++counts_.skipped_lines[parsed->skipped_tag];
  return WithContext(Accept(std::move(parsed->entries)), lines_.Where());
}

absl::Status LogReader::Accept(std::vector<LogEntry> entries) {
  for (const LogEntry& entry : entries) {
    ENFILADE_RETURN_IF_ERROR(sensor::Validate(entry.payload));
  }
  for (LogEntry& entry : entries) {
    if (const auto* scan = std::get_if<sensor::LaserScan>(&entry.payload)) {
      ++counts_.scans;
      counts_.scans_back_in_time += scan->time < last_scan_time_;
      last_scan_time_ = scan->time;
      const sensor::BeamCounts beams = sensor::CountBeams(*scan);
      counts_.beams_no_return += static_cast<std::int64_t>(beams.no_returns);
      counts_.beams_unknown += static_cast<std::int64_t>(beams.unknown);
    } else if (const auto* odometry = std::get_if<sensor::Odometry>(&entry.payload)) {
      ++counts_.odometry;
      counts_.odometry_back_in_time += odometry->time < last_odometry_time_;
      last_odometry_time_ = odometry->time;
    } else if (std::holds_alternative<sensor::Image>(entry.payload)) {
      ++counts_.images;
    } else {
      ++counts_.point_clouds;
    }
    pending_.push_back(std::move(entry));
  }
  return absl::OkStatus();
}

}  // namespace enfilade::sources
