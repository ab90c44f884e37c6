// SPDX-License-Identifier: Apache-2.0
#include "core/grid/log_odds_grid.h"

#include <algorithm>
#include <array>
#include <limits>

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::grid {
namespace {

// Limit of cell coordinates; differences and sums of a few of them then fit an int.
constexpr double kCoordinateLimit = 1e9;
// Windows grow in blocks and by a share of their size, so that a drive along a corridor seldom copies the cells.
constexpr int kBlock = 64;

std::int16_t UnitsOf(double probability) {
  return static_cast<std::int16_t>(
      std::lround(LogOddsGrid::kUnitsPerLogOdds * std::log(probability / (1.0 - probability))));
}

int FloorToBlock(std::int64_t value) {
  return static_cast<int>((value >= 0 ? value / kBlock : -((-value + kBlock - 1) / kBlock)) * kBlock);
}

// Widens [low, high), the bounds along one axis, to hold [need_low, need_high) with some spare room.
void Widen(std::int64_t need_low, std::int64_t need_high, std::int64_t& low, std::int64_t& high) {
  const std::int64_t room = std::max<std::int64_t>(kBlock, (high - low) / 4);
  if (need_low < low) low = FloorToBlock(need_low - room);
  if (need_high > high) high = FloorToBlock(need_high + room + kBlock - 1);
}

}  // namespace

absl::Status LogOddsOptions::Validate() const {
  if (!(p_hit > 0.5 && p_hit < 1.0)) return InvalidArgument("p_hit is {}: expected above 0.5 and below 1", p_hit);
  if (!(p_miss > 0.0 && p_miss < 0.5)) return InvalidArgument("p_miss is {}: expected above 0 and below 0.5", p_miss);
  if (!(p_min > 1e-6 && p_min < p_miss)) {
    return InvalidArgument("p_min is {}: expected above 1e-6 and below p_miss ({})", p_min, p_miss);
  }
  if (!(p_max > p_hit && p_max < 1.0 - 1e-6)) {
    return InvalidArgument("p_max is {}: expected above p_hit ({}) and below 1 - 1e-6", p_max, p_hit);
  }
  if (max_cells <= 0) return InvalidArgument("max_cells is {}: expected a positive number", max_cells);
  return absl::OkStatus();
}

LogOddsGrid::LogOddsGrid(double resolution, const LogOddsOptions& options)
    : resolution_(resolution),
      hit_(UnitsOf(options.p_hit)),
      miss_(UnitsOf(options.p_miss)),
      lowest_(UnitsOf(options.p_min)),
      highest_(UnitsOf(options.p_max)),
      max_cells_(options.max_cells) {}

absl::Status LogOddsGrid::Insert(const ScanRays& rays) {
  if (rays.hits.empty() && rays.free_ends.empty()) return absl::OkStatus();
  ENFILADE_ASSIGN_OR_RETURN(const Box bounds, BoundsOf(rays));
  ENFILADE_RETURN_IF_ERROR(Cover(bounds));
  StartScan();
  for (const Eigen::Vector2d& hit : rays.hits) {
    const std::size_t offset = OffsetOf(CellOf(hit));
    if (changed_by_[offset] == scan_) continue;
    changed_by_[offset] = scan_;
    const int value = cells_[offset] == kUnknown ? 0 : cells_[offset];
    cells_[offset] = static_cast<std::int16_t>(std::min(value + hit_, int{highest_}));
  }
  const CellIndex from = CellOf(rays.origin);
  CellIndex last = from;  // neighbouring beams often end in one cell
  for (const std::vector<Eigen::Vector2d>* ends : {&rays.hits, &rays.free_ends}) {
    for (const Eigen::Vector2d& end : *ends) {
      const CellIndex to = CellOf(end);
      if (to == last && to != from) continue;
      CastMisses(from, to);
      last = to;
    }
  }
  return absl::OkStatus();
}

// The scan's hits are already marked, so the last cell of a hit's ray is not changed.
void LogOddsGrid::CastMisses(CellIndex from, CellIndex to) {
  std::int16_t* const cells = cells_.data();
  std::uint8_t* const changed_by = changed_by_.data();
  const std::uint8_t scan = scan_;
  const int miss = miss_;
  const int lowest = lowest_;
  VisitLineOffsets(from, to, static_cast<std::ptrdiff_t>(OffsetOf(from)), width_, [=](std::ptrdiff_t offset) {
    // Branch-free: near the robot every other cell has already been changed.
    const int before = cells[offset];
    const int value = before == kUnknown ? 0 : before;
    const int after = std::max(value + miss, lowest);
    cells[offset] = static_cast<std::int16_t>(changed_by[offset] == scan ? before : after);
    changed_by[offset] = scan;
  });
}

void LogOddsGrid::StartScan() {
  if (changed_by_.size() != cells_.size()) {
    changed_by_.assign(cells_.size(), 0);
    scan_ = 0;
  }
  if (scan_ == std::numeric_limits<std::uint8_t>::max()) {
    std::fill(changed_by_.begin(), changed_by_.end(), std::uint8_t{0});
    scan_ = 0;
  }
  ++scan_;
}

absl::StatusOr<LogOddsGrid::Box> LogOddsGrid::BoundsOf(const ScanRays& rays) const {
  Eigen::Array2d low = rays.origin.array();
  Eigen::Array2d high = low;
  bool is_finite = low.allFinite();
  for (const std::vector<Eigen::Vector2d>* ends : {&rays.hits, &rays.free_ends}) {
    for (const Eigen::Vector2d& end : *ends) {
      is_finite = is_finite && end.allFinite();
      low = low.min(end.array());
      high = high.max(end.array());
    }
  }
  const double limit = kCoordinateLimit * resolution_;
  if (!is_finite || (low < -limit).any() || (high > limit).any()) {
    return InvalidArgument("a ray's end is not finite, or more than {} m from the grid's origin", limit);
  }
  return Box{CellOf(low.matrix()), CellOf(high.matrix())};
}

absl::Status LogOddsGrid::Cover(const Box& box) {
  std::int64_t left = min_.column;
  std::int64_t right = left + width_;
  std::int64_t bottom = min_.row;
  std::int64_t top = bottom + height_;
  if (cells_.empty()) {
    left = right = FloorToBlock(box.min.column);
    bottom = top = FloorToBlock(box.min.row);
  }
  Widen(box.min.column, std::int64_t{box.max.column} + 1, left, right);
  Widen(box.min.row, std::int64_t{box.max.row} + 1, bottom, top);
  if (right - left == width_ && top - bottom == height_) return absl::OkStatus();
  if (right - left > max_cells_ / (top - bottom)) {
    return ResourceExhausted("the scan would make the grid {} x {} cells, more than the limit of {}", right - left,
                             top - bottom, max_cells_);
  }
  MoveWindow({static_cast<int>(left), static_cast<int>(bottom)}, static_cast<int>(right - left),
             static_cast<int>(top - bottom));
  return absl::OkStatus();
}

// Cells in both windows keep their values.
void LogOddsGrid::MoveWindow(CellIndex min, int width, int height) {
  std::vector<std::int16_t> cells(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), kUnknown);
  const int left = std::max(min.column, min_.column);
  const int right = std::min(min.column + width, min_.column + width_);
  const int bottom = std::max(min.row, min_.row);
  const int top = std::min(min.row + height, min_.row + height_);
  for (int row = bottom; row < top && left < right; ++row) {
    const std::int16_t* const source = cells_.data() + OffsetOf({left, row});
    std::copy(source, source + (right - left),
              cells.data() + static_cast<std::size_t>(row - min.row) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(left - min.column));
  }
  cells_ = std::move(cells);
  changed_by_ = {};
  min_ = min;
  width_ = width;
  height_ = height;
}

LogOddsGrid::Box LogOddsGrid::KnownBox() const {
  constexpr int kMax = std::numeric_limits<int>::max();
  constexpr int kMin = std::numeric_limits<int>::min();
  Box box{{kMax, kMax}, {kMin, kMin}};
  const auto is_known = [](std::int16_t value) { return value != kUnknown; };
  for (int row = 0; row < height_; ++row) {
    const auto begin = cells_.begin() + static_cast<std::ptrdiff_t>(row) * width_;
    const auto end = begin + width_;
    const auto first = std::find_if(begin, end, is_known);
    if (first == end) continue;
    const auto last = std::find_if(std::make_reverse_iterator(end), std::make_reverse_iterator(begin), is_known);
    box.min.column = std::min(box.min.column, min_.column + static_cast<int>(first - begin));
    box.max.column = std::max(box.max.column, min_.column + static_cast<int>(last.base() - begin) - 1);
    box.min.row = std::min(box.min.row, min_.row + row);
    box.max.row = min_.row + row;
  }
  return box;
}

void LogOddsGrid::Crop() {
  const Box box = KnownBox();
  if (box.min.column > box.max.column) {
    MoveWindow({}, 0, 0);
  } else {
    MoveWindow(box.min, box.max.column - box.min.column + 1, box.max.row - box.min.row + 1);
  }
}

OccupancyGrid LogOddsGrid::ToOccupancyGrid(const Pose2& T_map_grid) const {
  OccupancyGrid grid;
  grid.geometry.resolution = resolution_;
  grid.geometry.T_map_grid = T_map_grid;
  const Box box = KnownBox();
  if (box.min.column > box.max.column) return grid;

  std::vector<std::uint8_t> cell_of(std::size_t{1} << 16, kUnknownCell);  // by the value's bits
  for (int value = lowest_; value <= highest_; ++value) {
    cell_of[static_cast<std::uint16_t>(value)] = CellFromProbability(ProbabilityOf(static_cast<std::int16_t>(value)));
  }
  grid.geometry.width = box.max.column - box.min.column + 1;
  grid.geometry.height = box.max.row - box.min.row + 1;
  grid.geometry.T_map_grid = T_map_grid * Pose2{box.min.column * resolution_, box.min.row * resolution_, 0.0};
  grid.cells.resize(grid.geometry.cell_count());
  for (int row = 0; row < grid.geometry.height; ++row) {
    const std::int16_t* const source = cells_.data() + OffsetOf({box.min.column, box.min.row + row});
    std::uint8_t* const target = grid.cells.data() + grid.geometry.index(0, row);
    for (int column = 0; column < grid.geometry.width; ++column) {
      target[column] = cell_of[static_cast<std::uint16_t>(source[column])];
    }
  }
  return grid;
}

absl::StatusOr<LogOddsGrid> LogOddsGrid::FromWindow(double resolution, const LogOddsOptions& options, Window window) {
  if (window.width < 0 || window.height < 0 ||
      static_cast<std::int64_t>(window.cells.size()) != std::int64_t{window.width} * window.height) {
    return InvalidArgument("{} cells for a window of {} x {}", window.cells.size(), window.width, window.height);
  }
  LogOddsGrid grid(resolution, options);
  for (std::int16_t& value : window.cells) {
    if (value != kUnknown) value = std::clamp(value, grid.lowest_, grid.highest_);
  }
  grid.min_ = window.min;
  grid.width_ = window.width;
  grid.height_ = window.height;
  grid.cells_ = std::move(window.cells);
  return grid;
}

void LogOddsGrid::Write(BinaryWriter& writer) const {
  writer.Put(resolution_);
  writer.Put<std::int32_t>(min_.column);
  writer.Put<std::int32_t>(min_.row);
  writer.Put<std::int32_t>(width_);
  writer.Put<std::int32_t>(height_);
  writer.PutVector(cells_);
}

absl::StatusOr<LogOddsGrid> LogOddsGrid::Read(BinaryReader& reader, const LogOddsOptions& options) {
  const auto resolution = reader.Get<double>();
  LogOddsGrid grid(resolution, options);
  grid.min_.column = reader.Get<std::int32_t>();
  grid.min_.row = reader.Get<std::int32_t>();
  grid.width_ = reader.Get<std::int32_t>();
  grid.height_ = reader.Get<std::int32_t>();
  grid.cells_ = reader.GetVector<std::int16_t>();
  const auto plausible = [](int min, int size) { return size >= 0 && std::abs(static_cast<double>(min)) + size < 2e9; };
  if (!reader.ok() || !(resolution > 0.0) || !std::isfinite(resolution) || !plausible(grid.min_.column, grid.width_) ||
      !plausible(grid.min_.row, grid.height_) ||
      static_cast<std::int64_t>(grid.cells_.size()) != std::int64_t{grid.width_} * grid.height_) {
    return DataLoss("the bytes are not those of a log-odds grid");
  }
  // Compiles to vector instructions: grids are large. kUnknown is below all other values.
  std::int16_t least = grid.highest_;
  std::int16_t most = grid.lowest_;
  for (const std::int16_t value : grid.cells_) {
    least = std::min(least, value == kUnknown ? grid.highest_ : value);
    most = std::max(most, value);
  }
  if (least < grid.lowest_ || most > grid.highest_) {
    return DataLoss("log-odds cells hold values from {} to {}, beyond the bounds {} and {} of the options", least, most,
                    grid.lowest_, grid.highest_);
  }
  return grid;
}

}  // namespace enfilade::grid
