// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/distance_field.h"

#include <algorithm>

namespace enfilade::rooms {
namespace {

constexpr std::int64_t kFar = std::int64_t{1} << 20;  // cells

// The row of the nearest obstacle in each column, kFar away if there is none.
std::vector<std::int32_t> NearestInColumns(const GroundMap& ground) {
  std::vector<std::int32_t> rows(ground.cells.size());
  for (int column = 0; column < ground.width; ++column) {
    auto last = static_cast<std::int32_t>(-kFar);
    for (int row = 0; row < ground.height; ++row) {
      if (!ground.IsOpen(ground.index(column, row))) last = row;
      rows[ground.index(column, row)] = last;
    }
    last = static_cast<std::int32_t>(kFar) + ground.height;
    for (int row = ground.height - 1; row >= 0; --row) {
      std::int32_t& best = rows[ground.index(column, row)];
      if (best == row) last = row;
      if (last - row < row - best) best = last;
    }
  }
  return rows;
}

// The lower envelope of one row's parabolas.
class RowEnvelope {
 public:
  RowEnvelope(const GroundMap& ground, const std::vector<std::int32_t>& rows)
      : ground_(ground), rows_(rows), site_(static_cast<std::size_t>(ground.width)), from_(site_.size()) {}

  void Run(int row, DistanceField& field) {
    const auto height = [&](int column) {
      const std::int64_t d = std::int64_t{rows_[ground_.index(column, row)]} - row;
      return d * d;
    };
    const auto value = [&](int x, int column) { return std::int64_t{x - column} * (x - column) + height(column); };
    std::size_t top = 0;
    site_[0] = 0;
    from_[0] = 0;
    bool empty = false;
    for (int u = 1; u < ground_.width; ++u) {
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
      if (meet >= ground_.width) continue;
      ++top;
      site_[top] = u;
      from_[top] = static_cast<int>(meet);
    }
    for (int x = ground_.width - 1; x >= 0; --x) {
      const std::size_t cell = ground_.index(x, row);
      const std::int64_t squared = value(x, site_[top]);
      field.distance[cell] = static_cast<float>(std::sqrt(static_cast<double>(squared)));
      const std::int32_t nearest_row = rows_[ground_.index(site_[top], row)];
      const bool exists = nearest_row >= 0 && nearest_row < ground_.height;
      field.nearest[cell] =
          exists ? static_cast<std::uint32_t>(ground_.index(site_[top], nearest_row)) : DistanceField::kNone;
      if (x == from_[top] && top > 0) --top;
    }
  }

 private:
  const GroundMap& ground_;
  const std::vector<std::int32_t>& rows_;
  std::vector<int> site_;
  std::vector<int> from_;
};

}  // namespace

DistanceField DistancesToWalls(const GroundMap& ground) {
  DistanceField field{std::vector<float>(ground.cells.size()), std::vector<std::uint32_t>(ground.cells.size())};
  const std::vector<std::int32_t> rows = NearestInColumns(ground);
  RowEnvelope envelope(ground, rows);
  for (int row = 0; row < ground.height; ++row) envelope.Run(row, field);
  return field;
}

}  // namespace enfilade::rooms
