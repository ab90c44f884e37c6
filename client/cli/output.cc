// SPDX-License-Identifier: Apache-2.0
#include "client/cli/output.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iostream>
#include <utility>

#include "fmt/format.h"

namespace enfilade::cli {
namespace {

using std::chrono::steady_clock;

constexpr int kBarWidth = 24;
constexpr auto kRedraw = std::chrono::milliseconds(100);
constexpr auto kLogLine = std::chrono::seconds(5);

std::size_t Width(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string Amount(std::int64_t value, const std::string& unit) {
  return unit == "B" ? FormatBytes(value) : std::to_string(value);
}

std::string Bar(double share) {
  const int filled = static_cast<int>(std::lround(std::clamp(share, 0.0, 1.0) * kBarWidth));
  std::string bar(static_cast<std::size_t>(filled), '=');
  if (filled > 0 && filled < kBarWidth) bar.back() = '>';
  bar.resize(kBarWidth, ' ');
  return bar;
}

}  // namespace

std::string ToLine(const Progress& progress) {
  std::string line = progress.label;
  if (progress.total > 0) {
    const double share = static_cast<double>(progress.done) / static_cast<double>(progress.total);
    line += fmt::format("  [{}] {:3d} %  {}/{}", Bar(share), static_cast<int>(std::clamp(share, 0.0, 1.0) * 100.0),
                        Amount(progress.done, progress.unit), Amount(progress.total, progress.unit));
  } else {
    line += "  " + Amount(progress.done, progress.unit);
  }
  if (!progress.unit.empty() && progress.unit != "B") line += " " + progress.unit;
  const auto here = static_cast<double>(progress.done - progress.first);
  if (progress.elapsed_s > 0.2 && here > 0.0) {
    const double rate = here / progress.elapsed_s;
    line += progress.unit == "B" ? fmt::format("  {}/s", FormatBytes(std::llround(rate)))
                                 : fmt::format("  {:.{}f}/s", rate, rate < 10.0 ? 1 : 0);
    const auto left = static_cast<double>(progress.total - progress.done);
    if (progress.total > 0 && left > 0.0) line += fmt::format("  {} left", FormatSeconds(left / rate));
  }
  if (!progress.note.empty()) line += "  " + progress.note;
  return line;
}

ProgressBar::ProgressBar(const Globals& globals, std::string label, std::int64_t total, std::string unit)
    : shown_(!globals.quiet && !globals.json),
      terminal_(isatty(STDERR_FILENO) == 1),
      label_(std::move(label)),
      total_(total),
      unit_(std::move(unit)),
      start_(steady_clock::now()),
      next_draw_(start_ + std::chrono::seconds(1)) {}

ProgressBar::~ProgressBar() { Finish(); }

void ProgressBar::Update(std::int64_t done, const std::string& note) {
  const auto now = steady_clock::now();
  if (first_ < 0) {
    first_ = done;
    start_ = now;
  }
  done_ = done;
  note_ = note;
  if (shown_ && !finished_ && now >= next_draw_) Draw(now);
}

void ProgressBar::Draw(steady_clock::time_point now) {
  const double elapsed_s = std::chrono::duration<double>(now - start_).count();
  const std::string line = ToLine({label_, std::max<std::int64_t>(first_, 0), done_, total_, unit_, elapsed_s, note_});
  const std::size_t width = Width(line);
  if (terminal_) {
    std::cerr << '\r' << line << std::string(drawn_width_ > width ? drawn_width_ - width : 0, ' ') << std::flush;
  } else {
    std::cerr << line << std::endl;
  }
  drawn_width_ = width;
  next_draw_ = now + (terminal_ ? steady_clock::duration(kRedraw) : steady_clock::duration(kLogLine));
}

void ProgressBar::Finish() {
  if (finished_) return;
  finished_ = true;
  if (!shown_ || drawn_width_ == 0) return;  // it took less than a second
  Draw(steady_clock::now());
  if (terminal_) std::cerr << std::endl;
}

void PrintTable(std::ostream& out, const std::vector<std::string>& header,
                const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  const auto widen = [&](const std::vector<std::string>& row) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], Width(row[i]));
  };
  widen(header);
  for (const auto& row : rows) widen(row);
  const auto print = [&](const std::vector<std::string>& row) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      out << row[i];
      if (i + 1 < row.size()) out << std::string(widths[i] - Width(row[i]) + 2, ' ');
    }
    out << '\n';
  };
  print(header);
  for (const auto& row : rows) print(row);
}

void PrintJson(std::ostream& out, const nlohmann::json& document) {
  out << document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
}

std::string FormatBytes(std::int64_t bytes) {
  if (bytes < 1024) return fmt::format("{} B", bytes);
  constexpr const char* kUnits[] = {"KiB", "MiB", "GiB", "TiB"};
  double value = static_cast<double>(bytes) / 1024.0;
  std::size_t unit = 0;
  while (value >= 1023.95 && unit + 1 < std::size(kUnits)) {
    value /= 1024.0;
    ++unit;
  }
  return fmt::format("{:.1f} {}", value, kUnits[unit]);
}

std::string FormatSeconds(double seconds) {
  if (!(seconds >= 0.0) || seconds > 1e9) return "?";
  if (seconds < 9.995) return fmt::format("{:.2f} s", seconds);
  if (seconds < 59.95) return fmt::format("{:.1f} s", seconds);
  const auto whole = static_cast<std::int64_t>(std::llround(seconds));
  if (whole < 3600) return fmt::format("{}:{:02d}", whole / 60, whole % 60);
  return fmt::format("{}:{:02d}:{:02d}", whole / 3600, whole / 60 % 60, whole % 60);
}

std::string EnumText(const std::string& name, const std::string& prefix) {
  std::string text = name.starts_with(prefix) ? name.substr(prefix.size()) : name;
  for (char& c : text) c = c == '_' ? ' ' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace enfilade::cli
