// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/campus/drawing.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include "core/base/error.h"

namespace enfilade::simulator {
namespace {

class Cells {
 public:
  explicit Cells(std::vector<std::string> rows) : rows_(std::move(rows)) {
    for (const std::string& row : rows_) width_ = std::max(width_, static_cast<int>(row.size()));
  }
  int width() const { return width_; }
  int height() const { return static_cast<int>(rows_.size()); }
  // Row 0 is the lowest. Outside of the drawing everything is free ground.
  char At(int column, int row) const {
    if (row < 0 || column < 0 || row >= height()) return ' ';
    const std::string& cells = rows_[static_cast<std::size_t>(height() - 1 - row)];
    return static_cast<std::size_t>(column) < cells.size() ? cells[static_cast<std::size_t>(column)] : ' ';
  }
  bool IsWall(int column, int row) const { return At(column, row) == '#'; }

 private:
  std::vector<std::string> rows_;
  int width_ = 0;
};

// Adds the edges between wall and free ground along the grid lines of one direction, joined into sheets that are as
// long as possible.
void AddSheets(const Cells& cells, bool horizontal, double cell, const Eigen::Vector2d& origin, Drawing& drawing) {
  const int lines = horizontal ? cells.height() : cells.width();
  const int along = horizontal ? cells.width() : cells.height();
  const auto wall = [&](int i, int line) { return horizontal ? cells.IsWall(i, line) : cells.IsWall(line, i); };
  for (int line = 0; line <= lines; ++line) {
    int begin = -1;
    for (int i = 0; i <= along; ++i) {
      const bool edge = i < along && wall(i, line) != wall(i, line - 1);
      if (edge && begin < 0) begin = i;
      if (edge || begin < 0) continue;
      const auto point = [&](int at) {
        const Eigen::Vector2d p = horizontal ? Eigen::Vector2d(at, line) : Eigen::Vector2d(line, at);
        return Eigen::Vector2d(origin + cell * p);
      };
      Wall sheet;
      sheet.points = {point(begin), point(i)};
      sheet.thickness = 0.0;
      drawing.walls.push_back(std::move(sheet));
      begin = -1;
    }
  }
}

}  // namespace

absl::StatusOr<Drawing> ParseDrawing(std::string_view text, double cell, const Eigen::Vector2d& origin) {
  if (!(cell >= 0.01 && cell <= 100.0))
    return InvalidArgument("a drawing has cells of {} m: expected 0.01 to 100", cell);
  std::vector<std::string> rows;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    if (const std::string_view row = text.substr(0, end); !row.empty()) rows.emplace_back(row);
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
  }
  if (rows.empty()) return InvalidArgument("a drawing has no rows");
  const Cells cells(std::move(rows));
  Drawing drawing;
  for (int row = 0; row < cells.height(); ++row) {
    for (int column = 0; column < cells.width(); ++column) {
      const char c = cells.At(column, row);
      if (std::isalpha(static_cast<unsigned char>(c)) == 0) continue;
      const Eigen::Vector2d middle = origin + cell * Eigen::Vector2d(column + 0.5, row + 0.5);
      if (!drawing.points.emplace(std::string(1, c), middle).second) {
        return InvalidArgument("a drawing has two points '{}'", c);
      }
    }
  }
  AddSheets(cells, true, cell, origin, drawing);
  AddSheets(cells, false, cell, origin, drawing);
  return drawing;
}

}  // namespace enfilade::simulator
