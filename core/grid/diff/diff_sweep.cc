// SPDX-License-Identifier: Apache-2.0
#include "core/grid/diff/diff_sweep.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/base/status_macros.h"
#include "core/grid/diff/diff_outlines.h"

namespace enfilade::grid {
namespace {

constexpr auto kFreeClass = static_cast<std::uint8_t>(CellClass::kFree);
constexpr auto kOccupiedClass = static_cast<std::uint8_t>(CellClass::kOccupied);

// The first cell from `i` on that has changed, or `size`.
int NextChange(const std::uint8_t* base, const std::uint8_t* revision, int i, int size) {
  while (i + 8 <= size && std::memcmp(base + i, revision + i, 8) == 0) i += 8;
  while (i < size && base[i] == revision[i]) ++i;
  return i;
}

ChangedRun RunOf(int row, int column, const std::uint8_t* revision, int size) {
  ChangedRun run{.row = row, .begin = column, .end = column + size};
  for (int i = 0; i < size; ++i) {
    run.to_free += revision[i] == kFreeClass ? 1U : 0U;
    run.to_occupied += revision[i] == kOccupiedClass ? 1U : 0U;
  }
  return run;
}

// Adds the runs of cells that are occupied in `of` and not in `other`.
absl::Status AddOccupied(int row, int column, const std::uint8_t* of, const std::uint8_t* other, int size,
                         ChangedRuns& runs) {
  for (int i = 0; i < size;) {
    const auto is_one = [&](int cell) { return of[cell] == kOccupiedClass && other[cell] != kOccupiedClass; };
    int end = i;
    while (end < size && is_one(end)) ++end;
    if (end > i) ENFILADE_RETURN_IF_ERROR(runs.Add({.row = row, .begin = column + i, .end = column + end}));
    i = end + 1;
  }
  return absl::OkStatus();
}

MapDiffRegion RegionOf(const ChangedGroup& group, const DiffLattice& lattice) {
  MapDiffRegion region;
  region.cells = group.cells;
  region.to = group.to;
  const Eigen::Vector2d low(group.min.column, group.min.row);
  const Eigen::Vector2d high(group.max.column + 1, group.max.row + 1);
  const std::array<Eigen::Vector2d, 4> corners = {low, Eigen::Vector2d(high.x(), low.y()), high,
                                                  Eigen::Vector2d(low.x(), high.y())};
  std::transform(corners.begin(), corners.end(), region.box.begin(), [&](const Eigen::Vector2d& corner) {
    return Eigen::Vector2d(lattice.T_map_lattice * (corner * lattice.resolution));
  });
  return region;
}

}  // namespace

DiffSweep::DiffSweep(const DiffLattice& lattice, const MapDiffOptions& options) : lattice_(lattice), options_(options) {
  if (options.with_picture) picture_.emplace(lattice, options.max_picture_side);
}

absl::Status DiffSweep::Add(int row, int column, const std::uint8_t* base, const std::uint8_t* revision, int size) {
  if (picture_) picture_->Add(row, column, base, revision, size);
  if (base == revision || std::memcmp(base, revision, static_cast<std::size_t>(size)) == 0) {
    CountUnchanged(revision, size);
    return absl::OkStatus();
  }
  for (int i = 0; i < size; ++i) ++pairs_[static_cast<std::size_t>(i) % 2][4U * base[i] + revision[i]];
  for (int begin = NextChange(base, revision, 0, size); begin < size;) {
    int end = begin + 1;
    while (end < size && base[end] != revision[end]) ++end;
    ENFILADE_RETURN_IF_ERROR(AddRun(row, column + begin, base + begin, revision + begin, end - begin));
    begin = NextChange(base, revision, end, size);
  }
  return absl::OkStatus();
}

// Without a table, so that the compiler counts many cells at once.
void DiffSweep::CountUnchanged(const std::uint8_t* classes, int size) {
  int free = 0;
  int occupied = 0;
  for (int i = 0; i < size; ++i) {
    free += classes[i] == kFreeClass ? 1 : 0;
    occupied += classes[i] == kOccupiedClass ? 1 : 0;
  }
  pairs_[0][4U * kFreeClass + kFreeClass] += free;
  pairs_[0][4U * kOccupiedClass + kOccupiedClass] += occupied;
}

absl::Status DiffSweep::AddRun(int row, int column, const std::uint8_t* base, const std::uint8_t* revision, int size) {
  ENFILADE_RETURN_IF_ERROR(changed_.Add(RunOf(row, column, revision, size)));
  if (!options_.with_geojson) return absl::OkStatus();
  ENFILADE_RETURN_IF_ERROR(AddOccupied(row, column, revision, base, size, came_));
  return AddOccupied(row, column, base, revision, size, went_);
}

absl::StatusOr<MapDiff> DiffSweep::Finish() && {
  MapDiff diff;
  diff.resolution = lattice_.resolution;
  std::int64_t told = 0;
  for (std::size_t from = 0; from < 3; ++from) {
    for (std::size_t to = 0; to < 3; ++to) {
      const std::int64_t count = pairs_[0][4 * from + to] + pairs_[1][4 * from + to];
      if (from == 0 && to == 0) continue;
      diff.cells[3 * from + to] = count;
      told += count;
    }
  }
  diff.cells[0] = lattice_.cell_count() - told;
  changed_.Group();
  diff.region_count = static_cast<std::int64_t>(changed_.group_count());
  for (const ChangedGroup& group : changed_.Largest(options_.max_regions)) {
    diff.regions.push_back(RegionOf(group, lattice_));
  }
  if (picture_) diff.picture = std::move(*picture_).Finish();
  if (options_.with_geojson) {
    came_.Group();
    went_.Group();
    ENFILADE_ASSIGN_OR_RETURN(diff.geojson, OutlinesToGeoJson(came_, went_, lattice_, options_.max_regions));
  }
  return diff;
}

}  // namespace enfilade::grid
