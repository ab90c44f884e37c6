// SPDX-License-Identifier: Apache-2.0
#include "core/slam/submaps/submap_grid.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/slam/submaps/robot_rays.h"

namespace enfilade::slam {
namespace {

constexpr int kSimplifiedClamp = 10;        // steps
constexpr double kSimplifiedStep = 0.35;    // log-odds: the clamp of 10 steps is a probability of 0.97
constexpr std::int32_t kMaxCount = 1'000;   // so that a mean keeps following new hits
constexpr double kMeanStep = 1.0 / 4096.0;  // m: a power of two, so that rounded means have few digits
constexpr double kMinProbability = 1e-6;    // so that log-odds are finite
// Of a submap that scans grow: 410 m x 410 m at 5 cm, 200 MB. Twice the side of what the largest extent and range need.
constexpr std::int64_t kMaxCells = std::int64_t{1} << 26;

double Probability(double log_odds) { return 1.0 / (1.0 + std::exp(-log_odds)); }

// The lowest and highest corner of the cells that the rays touch.
std::pair<grid::CellIndex, grid::CellIndex> Bounds(const grid::LogOddsGrid& grid, const grid::ScanRays& rays) {
  Eigen::Vector2d low = rays.origin;
  Eigen::Vector2d high = rays.origin;
  for (const std::vector<Eigen::Vector2d>* ends : {&rays.hits, &rays.free_ends}) {
    for (const Eigen::Vector2d& end : *ends) {
      low = low.cwiseMin(end);
      high = high.cwiseMax(end);
    }
  }
  return {grid.CellOf(low), grid.CellOf(high)};
}

bool IsBefore(const SubmapGrid::Hits::value_type& a, const SubmapGrid::Hits::value_type& b) {
  return a.first < b.first;
}

}  // namespace

grid::LogOddsOptions LogOddsOptionsOf(const OccupancyOptions& options) {
  grid::LogOddsOptions result;
  result.max_cells = kMaxCells;
  if (options.log_odds) {
    result.p_hit = options.hit_probability;
    result.p_miss = options.miss_probability;
    result.p_min = options.min_probability;
    result.p_max = options.max_probability;
  } else {
    result.p_hit = Probability(kSimplifiedStep);
    result.p_miss = Probability(-kSimplifiedStep);
    result.p_min = Probability(-kSimplifiedClamp * kSimplifiedStep);
    result.p_max = Probability(kSimplifiedClamp * kSimplifiedStep);
  }
  return result;
}

SubmapGrid::SubmapGrid(double resolution, const OccupancyOptions& options)
    : log_odds_(resolution, LogOddsOptionsOf(options)) {}

SubmapGrid SubmapGrid::FromOccupancy(const grid::OccupancyGrid& grid, const OccupancyOptions& options) {
  const grid::GridGeometry& geometry = grid.geometry;
  const double r = geometry.resolution;
  const grid::CellIndex min{static_cast<int>(std::lround(geometry.T_map_grid.x / r)),
                            static_cast<int>(std::lround(geometry.T_map_grid.y / r))};
  std::vector<std::int16_t> cells(grid.cells.size(), grid::LogOddsGrid::kUnknown);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (grid.cells[i] == grid::kUnknownCell) continue;
    const double p = std::clamp(grid::ProbabilityOfCell(grid.cells[i]), kMinProbability, 1.0 - kMinProbability);
    cells[i] = static_cast<std::int16_t>(std::lround(grid::LogOddsGrid::kUnitsPerLogOdds * std::log(p / (1.0 - p))));
  }
  SubmapGrid result(grid::LogOddsGrid::FromWindow(r, LogOddsOptionsOf(options),
                                                  {min, geometry.width, geometry.height, std::move(cells)})
                        .value());  // the geometry gives the number of cells
  const grid::LogOddsGrid& log_odds = result.log_odds_;
  for (int row = 0; row < geometry.height; ++row) {
    for (int column = 0; column < geometry.width; ++column) {
      const grid::CellIndex cell{min.column + column, min.row + row};
      if (log_odds.ValueAt(cell) <= 0) continue;  // kUnknown included
      const Eigen::Vector2d centre((cell.column + 0.5) * r, (cell.row + 0.5) * r);
      result.hits_.emplace_back(Key{cell.row, cell.column}, HitMean{centre, 1});
    }
  }
  return result;
}

absl::StatusOr<std::vector<grid::CellIndex>> SubmapGrid::Insert(const Pose2& T_submap_robot,
                                                                const grid::ScanRays& rays) {
  const grid::ScanRays placed = Transformed(T_submap_robot, rays);
  const auto [low, high] = Bounds(log_odds_, placed);
  // Occupied cells that this scan may turn free.
  std::vector<Key> occupied;
  VisitOccupied(low, high, [&](grid::CellIndex cell, const Eigen::Vector2d&) {
    occupied.push_back({cell.row, cell.column});
  });
  ENFILADE_RETURN_IF_ERROR(log_odds_.Insert(placed));
  std::erase_if(occupied, [&](const Key& key) { return IsOccupied({key.second, key.first}); });
  const std::vector<Key> hit = AddHits(placed.hits);
  std::vector<Key> changed;
  std::set_union(occupied.begin(), occupied.end(), hit.begin(), hit.end(), std::back_inserter(changed));
  std::vector<grid::CellIndex> cells;
  cells.reserve(changed.size());
  for (const Key& key : changed) cells.push_back({key.second, key.first});
  return cells;
}

// Returns the cells of the hits in order, each once.
std::vector<SubmapGrid::Key> SubmapGrid::AddHits(const std::vector<Eigen::Vector2d>& hits) {
  std::vector<std::pair<Key, Eigen::Vector2d>> sorted;
  sorted.reserve(hits.size());
  for (const Eigen::Vector2d& hit : hits) {
    const grid::CellIndex cell = log_odds_.CellOf(hit);
    sorted.emplace_back(Key{cell.row, cell.column}, hit);
  }
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Key> cells;
  Hits fresh;  // of cells without hits so far
  HitMean* mean = nullptr;
  for (const auto& [key, hit] : sorted) {
    if (cells.empty() || cells.back() != key) {
      cells.push_back(key);
      const auto known = FirstFrom(hits_, key);
      const bool is_known = known != hits_.end() && known->first == key;
      mean = is_known ? &known->second : &fresh.emplace_back(key, HitMean{}).second;
    }
    mean->count = std::min(mean->count + 1, kMaxCount);
    mean->mean += (hit - mean->mean) / mean->count;
  }
  const auto before = static_cast<std::ptrdiff_t>(hits_.size());
  hits_.insert(hits_.end(), fresh.begin(), fresh.end());
  std::inplace_merge(hits_.begin(), hits_.begin() + before, hits_.end(), IsBefore);
  return cells;
}

std::vector<Eigen::Vector2d> SubmapGrid::OccupiedPoints() const {
  std::vector<Eigen::Vector2d> points;
  for (const auto& [key, hit] : hits_) {
    if (IsOccupied({key.second, key.first})) points.push_back(hit.mean);
  }
  return points;
}

void SubmapGrid::RoundMeans() {
  for (auto& [key, hit] : hits_) hit.mean = (hit.mean / kMeanStep).array().round().matrix() * kMeanStep;
}

std::size_t SubmapGrid::bytes() const {
  return log_odds_.cells().capacity() * sizeof(std::int16_t) + hits_.capacity() * sizeof(Hits::value_type);
}

// All values of one kind together: this compresses far better than cell by cell.
void SubmapGrid::Serialize(BinaryWriter& writer) const {
  log_odds_.Write(writer);
  writer.Put<std::uint64_t>(hits_.size());
  for (const auto& [key, hit] : hits_) writer.Put<std::int32_t>(key.first);
  for (const auto& [key, hit] : hits_) writer.Put<std::int32_t>(key.second);
  for (const auto& [key, hit] : hits_) writer.Put(hit.count);
  for (const auto& [key, hit] : hits_) writer.Put(hit.mean.x());
  for (const auto& [key, hit] : hits_) writer.Put(hit.mean.y());
}

absl::StatusOr<SubmapGrid> SubmapGrid::Deserialize(BinaryReader& reader, const OccupancyOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(grid::LogOddsGrid log_odds, grid::LogOddsGrid::Read(reader, LogOddsOptionsOf(options)));
  SubmapGrid grid(std::move(log_odds));
  const auto size = reader.Get<std::uint64_t>();
  if (size > reader.remaining() / 28) return DataLoss("a submap's grid is truncated");
  grid.hits_.resize(size);
  for (auto& [key, hit] : grid.hits_) key.first = reader.Get<std::int32_t>();
  for (auto& [key, hit] : grid.hits_) key.second = reader.Get<std::int32_t>();
  for (auto& [key, hit] : grid.hits_) hit.count = reader.Get<std::int32_t>();
  for (auto& [key, hit] : grid.hits_) hit.mean.x() = reader.Get<double>();
  for (auto& [key, hit] : grid.hits_) hit.mean.y() = reader.Get<double>();
  const auto is_not_before = [](const auto& a, const auto& b) { return !IsBefore(a, b); };
  const bool ordered = std::adjacent_find(grid.hits_.begin(), grid.hits_.end(), is_not_before) == grid.hits_.end();
  if (!reader.ok() || !ordered) return DataLoss("a submap's grid is damaged");
  return grid;
}

}  // namespace enfilade::slam
