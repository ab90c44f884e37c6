// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <iostream>
#include <ostream>
#include <string>
#include <vector>

#include "client/cli/command.h"
#include "nlohmann/json.hpp"

namespace enfilade::cli {

// A progress bar on standard error, shown once an operation takes longer than a second:
//   sending  [=========>          ]  45 %  1234/2726  310/s  0:05 left
// A terminal shows it in place; elsewhere (a log file, CI) a new line appears every few seconds. Prints nothing with
// --quiet and --json. Not thread-safe.
class ProgressBar {
 public:
  // `total` 0: unknown, only the count is shown. `unit`: what is counted; "B" is shown as KiB, MiB ...
  ProgressBar(const Globals& globals, std::string label, std::int64_t total, std::string unit = "");
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  // May be called often: it draws at most ten times a second. `note` is shown at the end of the line.
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
  std::int64_t first_ = -1;  // the count at the first update, which an earlier run did: not in the rate
  std::int64_t done_ = 0;
  std::string note_;
  std::size_t drawn_width_ = 0;
  bool finished_ = false;
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point next_draw_;
};

// The text of a bar's line. `elapsed_s`: since the count was `first`.
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

// Columns as wide as their widest cell (in UTF-8 characters), two spaces between them; the last column is not padded.
void PrintTable(std::ostream& out, const std::vector<std::string>& header,
                const std::vector<std::vector<std::string>>& rows);

// One document, indented by two, with a newline. Invalid UTF-8 is replaced.
void PrintJson(std::ostream& out, const nlohmann::json& document);

// A list on standard output: with --json one array of `to_json`, else a table of `to_row`.
template <typename Item>
void PrintList(const Globals& globals, const std::vector<Item>& items, const std::vector<std::string>& header,
               nlohmann::json (*to_json)(const Item&), std::vector<std::string> (*to_row)(const Item&)) {
  if (globals.json) {
    nlohmann::json documents = nlohmann::json::array();
    for (const Item& item : items) documents.push_back(to_json(item));
    return PrintJson(std::cout, documents);
  }
  std::vector<std::vector<std::string>> rows;
  for (const Item& item : items) rows.push_back(to_row(item));
  PrintTable(std::cout, header, rows);
}

std::string FormatBytes(std::int64_t bytes);  // "512 B", "1.5 KiB", "64.0 MiB"
std::string FormatSeconds(double seconds);    // "0.42 s", "12.3 s", "5:07", "1:02:03"

// A protobuf enum's value for people: the name without its prefix, in lower case, with spaces for underscores.
// EnumText("DECISION_MAP_ENTERED", "DECISION_") is "map entered".
std::string EnumText(const std::string& name, const std::string& prefix);

}  // namespace enfilade::cli
