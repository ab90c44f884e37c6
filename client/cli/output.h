// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "client/cli/command.h"
#include "nlohmann/json.hpp"

namespace enfilade::cli {

// A bar on standard error for whatever takes longer than a second:
//   sending  [=========>          ]  45 %  1234/2726  310/s  0:05 left
// On a terminal it is redrawn in place, elsewhere (a log file, CI) a line appears every few seconds. With --quiet and
// --json nothing is printed. Not thread-safe.
class ProgressBar {
 public:
  // `total` 0: not known, only the count is shown. `unit`: of what is counted, for the rate; "B" shows bytes as KiB,
  // MiB.
  ProgressBar(const Globals& globals, std::string label, std::int64_t total, std::string unit = "");
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  // May be called as often as convenient; draws at most ten times a second. `note` is shown at the end of the line.
  void Update(std::int64_t done, const std::string& note = "");
  void SetTotal(std::int64_t total) { total_ = total; }
  // Draws the last state and ends the line. Further calls do nothing.
  void Finish();

 private:
  void Draw(std::chrono::steady_clock::time_point now);

  bool shown_;
  bool terminal_;
  std::string label_;
  std::int64_t total_;
  std::string unit_;
  std::int64_t first_ = -1;  // what was done at the first update: not of this run, so not in its rate
  std::int64_t done_ = 0;
  std::string note_;
  std::size_t drawn_width_ = 0;
  bool finished_ = false;
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point next_draw_;
};

// The text of a bar's line, apart from the terminal: `elapsed_s` since the count was `first`.
struct Progress {
  std::string label;
  std::int64_t first = 0;
  std::int64_t done = 0;
  std::int64_t total = 0;
  std::string unit;
  double elapsed_s = 0.0;
  std::string note;
};
std::string ToLine(const Progress& progress);

// Columns as wide as their widest cell (counted in UTF-8 characters), two spaces between them; the last is not padded.
void PrintTable(std::ostream& out, const std::vector<std::string>& header,
                const std::vector<std::vector<std::string>>& rows);

// One document, indented by two, with a newline. Invalid UTF-8 is replaced, never thrown on.
void PrintJson(std::ostream& out, const nlohmann::json& document);

std::string BytesInWords(std::int64_t bytes);  // "512 B", "1.5 KiB", "64.0 MiB"
std::string SecondsInWords(double seconds);    // "0.42 s", "12.3 s", "5:07", "1:02:03"

}  // namespace enfilade::cli
