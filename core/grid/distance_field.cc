// SPDX-License-Identifier: Apache-2.0
#include "core/grid/distance_field.h"

#include <cmath>

namespace enfilade::grid {
namespace {

constexpr std::int64_t kFar = std::int64_t{1} << 20;  // cells

std::size_t IndexOf(int width, int column, int row) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column);
}

// The row of the nearest marked cell in each column, kFar away if there is none.
std::vector<std::int32_t> NearestInColumns(int width, int height, const std::vector<std::uint8_t>& marked) {
  std::vector<std::int32_t> rows(marked.size());
  const auto columns = static_cast<std::size_t>(width);
  std::vector<std::int32_t> last(columns, static_cast<std::int32_t>(-kFar));  // in each column; rows lie together
  for (int row = 0; row < height; ++row) {
    const std::size_t first = IndexOf(width, 0, row);
    for (std::size_t i = 0; i < columns; ++i) {
      if (marked[first + i] != 0) last[i] = row;
      rows[first + i] = last[i];
    }
  }
  last.assign(columns, static_cast<std::int32_t>(kFar) + height);
  for (int row = height - 1; row >= 0; --row) {
    const std::size_t first = IndexOf(width, 0, row);
    for (std::size_t i = 0; i < columns; ++i) {
      std::int32_t& best = rows[first + i];
      if (best == row) last[i] = row;
      if (last[i] - row < row - best) best = last[i];
    }
  }
  return rows;
}

// The lower envelope of one row's parabolas.
class RowEnvelope {
 public:
  RowEnvelope(int width, int height, const std::vector<std::int32_t>& rows)
      : width_(width), height_(height), rows_(rows), site_(static_cast<std::size_t>(width)), from_(site_.size()) {}

  void Run(int row, DistanceField& field) {
    const auto height = [&](int column) {
      const std::int64_t d = std::int64_t{rows_[IndexOf(width_, column, row)]} - row;
      return d * d;
    };
    const auto value = [&](int x, int column) { return std::int64_t{x - column} * (x - column) + height(column); };
    const auto is_marked = [&](int column) { return rows_[IndexOf(width_, column, row)] == row; };
    std::size_t top = 0;
    site_[0] = 0;
    from_[0] = 0;
    bool empty = false;
    for (int u = 1; u < width_; ++u) {
      // Among marked cells each is its own nearest: in most maps most cells are unknown, and marked.
      if (site_[top] == u - 1 && from_[top] < u && is_marked(u) && is_marked(u - 1)) {
        ++top;
        site_[top] = u;
        from_[top] = u;
        continue;
      }
      while (!empty && value(from_[top], site_[top]) > value(from_[top], u)) {
        empty = top == 0;
        if (!empty) --top;
      }
      if (empty) {
        site_[0] = u;
        from_[0] = 0;
        top = 0;
        empty = false;
        continue;
      }
      const std::int64_t i = site_[top];
      const std::int64_t meet = 1 + (std::int64_t{u} * u - i * i + height(u) - height(site_[top])) / (2 * (u - i));
      if (meet >= width_) continue;
      ++top;
      site_[top] = u;
      from_[top] = static_cast<int>(meet);
    }
    for (int x = width_ - 1; x >= 0; --x) {
      const std::size_t cell = IndexOf(width_, x, row);
      if (site_[top] == x && is_marked(x)) {
        field.distance[cell] = 0.0F;
        field.nearest[cell] = static_cast<std::uint32_t>(cell);
        if (x == from_[top] && top > 0) --top;
        continue;
      }
      const std::int64_t squared = value(x, site_[top]);
      field.distance[cell] = static_cast<float>(std::sqrt(static_cast<double>(squared)));
      const std::int32_t nearest_row = rows_[IndexOf(width_, site_[top], row)];
      const bool exists = nearest_row >= 0 && nearest_row < height_;
      field.nearest[cell] =
          exists ? static_cast<std::uint32_t>(IndexOf(width_, site_[top], nearest_row)) : DistanceField::kNone;
      if (x == from_[top] && top > 0) --top;
    }
  }

 private:
  int width_;
  int height_;
  const std::vector<std::int32_t>& rows_;
  std::vector<int> site_;
  std::vector<int> from_;
};

}  // namespace

DistanceField DistancesTo(const std::vector<std::uint8_t>& marked, int width, int height) {
  DistanceField field{std::vector<float>(marked.size()), std::vector<std::uint32_t>(marked.size())};
  if (marked.empty()) return field;
  const std::vector<std::int32_t> rows = NearestInColumns(width, height, marked);
  RowEnvelope envelope(width, height, rows);
  for (int row = 0; row < height; ++row) envelope.Run(row, field);
  return field;
}

}  // namespace enfilade::grid
