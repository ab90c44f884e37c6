// SPDX-License-Identifier: Apache-2.0
#include "core/grid/diff/changed_runs.h"

#include <algorithm>
#include <tuple>

#include "core/base/error.h"

namespace enfilade::grid {

absl::Status ChangedRuns::Add(const ChangedRun& run) {
  const int band_row = run.row & ~(kBandRows - 1);  // also of negative rows
  if (band_row != band_row_) {
    EndBand();
    band_row_ = band_row;
  }
  std::vector<ChangedRun>& row = band_[static_cast<std::size_t>(run.row - band_row)];
  if (!row.empty() && row.back().end == run.begin) {
    row.back().end = run.end;
    row.back().to_free += run.to_free;
    row.back().to_occupied += run.to_occupied;
    return absl::OkStatus();
  }
  if (runs_.size() + in_band_ >= kMaxRuns) {
    return ResourceExhausted("the maps differ in more than {} places: compare maps that are more alike", kMaxRuns);
  }
  row.push_back(run);
  ++in_band_;
  return absl::OkStatus();
}

void ChangedRuns::EndBand() {
  for (std::vector<ChangedRun>& row : band_) {
    runs_.insert(runs_.end(), row.begin(), row.end());
    row.clear();
  }
  in_band_ = 0;
}

std::uint32_t ChangedRuns::RootOf(std::uint32_t run) {
  while (runs_[run].group != run) {
    runs_[run].group = runs_[runs_[run].group].group;
    run = runs_[run].group;
  }
  return run;
}

void ChangedRuns::Join(std::uint32_t a, std::uint32_t b) {
  a = RootOf(a);
  b = RootOf(b);
  runs_[std::max(a, b)].group = std::min(a, b);
}

// Each run against those of the row below, both from the left.
void ChangedRuns::Group() {
  EndBand();
  const auto count = static_cast<std::uint32_t>(runs_.size());
  for (std::uint32_t run = 0; run < count; ++run) runs_[run].group = run;
  std::uint32_t below = 0;
  for (std::uint32_t run = 0; run < count; ++run) {
    const ChangedRun& upper = runs_[run];
    while (below < run && (runs_[below].row < upper.row - 1 ||
                           (runs_[below].row == upper.row - 1 && runs_[below].end < upper.begin))) {
      ++below;
    }
    for (std::uint32_t i = below; i < run && runs_[i].row == upper.row - 1 && runs_[i].begin <= upper.end; ++i) {
      Join(i, run);
    }
  }
  for (std::uint32_t run = 0; run < count; ++run) {
    runs_[run].group = RootOf(run);
    group_count_ += runs_[run].group == run ? 1U : 0U;
  }
}

std::vector<ChangedGroup> ChangedRuns::Largest(std::size_t count) const {
  std::vector<ChangedGroup> groups;
  groups.reserve(group_count_);
  std::vector<std::uint32_t> place(runs_.size());  // of the group, by its first run
  for (std::uint32_t i = 0; i < runs_.size(); ++i) {
    const ChangedRun& run = runs_[i];
    if (run.group == i) {
      place[i] = static_cast<std::uint32_t>(groups.size());
      groups.push_back({.min = {run.begin, run.row}, .max = {run.end - 1, run.row}, .first_run = i});
    }
    ChangedGroup& group = groups[place[run.group]];
    group.min = {std::min(group.min.column, run.begin), std::min(group.min.row, run.row)};
    group.max = {std::max(group.max.column, run.end - 1), std::max(group.max.row, run.row)};
    const std::int64_t cells = std::int64_t{run.end} - run.begin;
    group.cells += cells;
    group.to[0] += cells - run.to_free - run.to_occupied;
    group.to[1] += run.to_free;
    group.to[2] += run.to_occupied;
  }
  const auto given = groups.begin() + static_cast<std::ptrdiff_t>(std::min(count, groups.size()));
  std::partial_sort(groups.begin(), given, groups.end(), [](const ChangedGroup& a, const ChangedGroup& b) {
    return std::tuple(-a.cells, a.min.row, a.min.column, a.first_run) <
           std::tuple(-b.cells, b.min.row, b.min.column, b.first_run);
  });
  groups.erase(given, groups.end());
  return groups;
}

}  // namespace enfilade::grid
