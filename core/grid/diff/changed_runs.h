// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "core/grid/bresenham.h"

namespace enfilade::grid {

// Cells of one row next to one another that have changed.
struct ChangedRun {
  int row = 0;
  int begin = 0;  // columns [begin, end)
  int end = 0;
  std::uint32_t group = 0;  // the index of its group's first run
  // Of the cells: those that became free and occupied. The others became unknown.
  std::uint32_t to_free = 0;
  std::uint32_t to_occupied = 0;
};

// Cells that touch one another, at a side or a corner.
struct ChangedGroup {
  CellIndex min;  // the box around them
  CellIndex max;
  std::int64_t cells = 0;
  std::array<std::int64_t, 3> to{};  // by CellClass
  std::uint32_t first_run = 0;       // in the list of runs
};

// The cells that have changed, as runs, and the groups that they form. Memory goes with the number of changes, not with
// the size of the rasters.
class ChangedRuns {
 public:
  // More are refused: 4,000 x 4,000 cells of which every other one has changed have 8 million.
  static constexpr std::size_t kMaxRuns = 10'000'000;

  // Adds a run on the right of those of its row, which it may continue. Rows come in bands: all runs of the rows
  // [256 i, 256 (i + 1)), in any order of these rows, before those of the next band. RESOURCE_EXHAUSTED above kMaxRuns.
  absl::Status Add(const ChangedRun& run);
  // To be called once, after all runs: joins those that touch.
  void Group();

  // After Group(): row by row, from the left.
  const std::vector<ChangedRun>& runs() const { return runs_; }
  std::size_t group_count() const { return group_count_; }
  // At most `count` groups, the largest first; of equal ones the lowest, then the leftmost.
  std::vector<ChangedGroup> Largest(std::size_t count) const;

 private:
  static constexpr int kBandRows = 256;

  void EndBand();
  std::uint32_t RootOf(std::uint32_t run);
  void Join(std::uint32_t a, std::uint32_t b);

  std::vector<ChangedRun> runs_;
  std::array<std::vector<ChangedRun>, kBandRows> band_;  // by row
  std::size_t in_band_ = 0;
  int band_row_ = 0;  // its first
  std::size_t group_count_ = 0;
};

}  // namespace enfilade::grid
