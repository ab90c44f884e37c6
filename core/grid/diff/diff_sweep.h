// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/grid/diff/changed_runs.h"
#include "core/grid/diff/diff_lattice.h"
#include "core/grid/diff/diff_picture.h"
#include "core/grid/diff/map_diff.h"

namespace enfilade::grid {

// Collects what MapDiff tells from pairs of rows of cells, given as CellClass.
class DiffSweep {
 public:
  DiffSweep(const DiffLattice& lattice, const MapDiffOptions& options);

  // Cells from `column` on. Rows come in the order of ChangedRuns::Add; what is never added is unknown in both. Errors
  // as ChangedRuns::Add.
  absl::Status Add(int row, int column, const std::uint8_t* base, const std::uint8_t* revision, int size);
  absl::StatusOr<MapDiff> Finish() &&;

 private:
  // Those that are unknown are counted by what is left.
  void CountUnchanged(const std::uint8_t* classes, int size);
  // Of cells that have all changed, next to one another.
  absl::Status AddRun(int row, int column, const std::uint8_t* base, const std::uint8_t* revision, int size);

  const DiffLattice lattice_;
  const MapDiffOptions options_;
  // 4 * from + to; two of each, so that a run of one class does not wait for itself.
  std::array<std::array<std::int64_t, 16>, 2> pairs_{};
  ChangedRuns changed_;
  ChangedRuns came_;
  ChangedRuns went_;
  std::optional<DiffPicture> picture_;
};

}  // namespace enfilade::grid
