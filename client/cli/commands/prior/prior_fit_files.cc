// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/prior/prior_fit_files.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "io/file.h"

namespace enfilade::cli {
namespace {

absl::StatusOr<std::vector<std::vector<double>>> ReadRows(const std::filesystem::path& path, std::size_t columns) {
  ENFILADE_ASSIGN_OR_RETURN(const std::string text, io::ReadFile(path));
  std::vector<std::vector<double>> rows;
  int number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string line = text.substr(begin, end - begin);
    begin = end + 1;
    ++number;
    std::erase_if(line, [](char c) { return c == ' ' || c == '\t' || c == '\r'; });
    if (line.empty() || line.front() == '#') continue;
    std::vector<double> row;
    for (const char* at = line.data();;) {
      const char* const last = line.data() + line.size();
      double value = 0;
      const auto [next, error] = std::from_chars(at, last, value);
      if (error != std::errc{} || !std::isfinite(value))
        return InvalidArgument("{}: line {}: not a number", path.string(), number);
      row.push_back(value);
      if (next == last) break;
      if (*next != ',') return InvalidArgument("{}: line {}: not a number", path.string(), number);
      at = next + 1;
    }
    if (row.size() != columns) {
      return InvalidArgument("{}: line {}: {} numbers, {} are needed", path.string(), number, row.size(), columns);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}
}  // namespace

absl::StatusOr<std::vector<prior::ControlPair>> ReadPairs(const std::filesystem::path& path) {
  ENFILADE_ASSIGN_OR_RETURN(const auto rows, ReadRows(path, 4));
  std::vector<prior::ControlPair> pairs;
  for (const std::vector<double>& row : rows) pairs.push_back({{row[0], row[1]}, {row[2], row[3]}});
  return pairs;
}

absl::StatusOr<std::vector<Eigen::Vector2d>> ReadSheetPoints(const std::filesystem::path& path) {
  ENFILADE_ASSIGN_OR_RETURN(const auto rows, ReadRows(path, 2));
  std::vector<Eigen::Vector2d> points;
  for (const std::vector<double>& row : rows) points.emplace_back(row[0], row[1]);
  return points;
}

std::string WriteLocatedPoints(const std::vector<Eigen::Vector2d>& points, const prior::PlanGraph& plan,
                               const prior::CorrectedPlan& corrected) {
  std::string text = "plan_x_px,plan_y_px,input_x_m,input_y_m,sigma_m,state\n";
  for (const Eigen::Vector2d& point : points) {
    const prior::CorrectedPoint located = corrected.Locate(prior::ToSheet(plan, point));
    text += fmt::format("{},{},{:.4f},{:.4f},{:.4f},{}\n", point.x(), point.y(), located.point.x(), located.point.y(),
                        located.sigma, prior::NameOf(located.sight));
  }
  return text;
}

}  // namespace enfilade::cli
