// SPDX-License-Identifier: Apache-2.0
#include "core/grid/diff/cell_outlines.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numeric>
#include <unordered_map>
#include <utility>

namespace enfilade::grid {
namespace {

// From corner to corner, with the cells on its left.
struct Side {
  CellIndex from;
  CellIndex to;
  std::size_t run = 0;
  bool used = false;
};

// The sides of cells that have no neighbour there, row by row.
class Sides {
 public:
  explicit Sides(const std::vector<ChangedRun>& runs) : runs_(runs), part_(runs.size()) {
    std::iota(part_.begin(), part_.end(), std::size_t{0});
    for (std::size_t begin = 0, end = 0; begin < runs.size(); begin = end) {
      end = EndOfRow(begin);
      const bool has_below = begin > 0 && runs[begin - 1].row == runs[begin].row - 1;
      const bool has_above = end < runs.size() && runs[end].row == runs[begin].row + 1;
      const std::size_t below = has_below ? FirstOfRow(begin - 1) : begin;
      const std::size_t above_end = has_above ? EndOfRow(end) : end;
      for (std::size_t run = begin; run < end; ++run) {
        AddEnds(run);
        AddUncovered(run, below, begin, false);
        AddUncovered(run, end, above_end, true);
      }
    }
  }

  std::vector<Side>& sides() { return sides_; }
  // The first run of the cells that touch `run` at sides, directly or by others.
  std::size_t PartOf(std::size_t run) {
    while (part_[run] != run) run = part_[run] = part_[part_[run]];
    return run;
  }

 private:
  std::size_t EndOfRow(std::size_t run) const {
    const int row = runs_[run].row;
    while (run < runs_.size() && runs_[run].row == row) ++run;
    return run;
  }
  std::size_t FirstOfRow(std::size_t run) const {
    const int row = runs_[run].row;
    while (run > 0 && runs_[run - 1].row == row) --run;
    return run;
  }

  void AddEnds(std::size_t run) {
    const ChangedRun& cells = runs_[run];
    sides_.push_back({{cells.end, cells.row}, {cells.end, cells.row + 1}, run});
    sides_.push_back({{cells.begin, cells.row + 1}, {cells.begin, cells.row}, run});
  }

  // What the runs [first, last) of a row beside it leave of its lower or upper side. Joins those that touch it.
  void AddUncovered(std::size_t run, std::size_t first, std::size_t last, bool upper) {
    const ChangedRun& cells = runs_[run];
    int free_from = cells.begin;
    const auto beyond = [&](std::size_t i) { return runs_[i].end <= cells.begin; };
    std::size_t neighbour = first;
    for (std::size_t step = last - first; step > 0;) {  // the first that is not beyond, by halves
      const std::size_t half = step / 2;
      if (beyond(neighbour + half)) {
        neighbour += half + 1;
        step -= half + 1;
      } else {
        step = half;
      }
    }
    for (; neighbour < last && runs_[neighbour].begin < cells.end; ++neighbour) {
      AddLevel(run, free_from, std::max(cells.begin, runs_[neighbour].begin), upper);
      free_from = std::min(cells.end, runs_[neighbour].end);
      const std::size_t a = PartOf(run);
      const std::size_t b = PartOf(neighbour);
      part_[std::max(a, b)] = std::min(a, b);
    }
    AddLevel(run, free_from, cells.end, upper);
  }
  void AddLevel(std::size_t run, int left, int right, bool upper) {
    if (left >= right) return;
    const int row = runs_[run].row;
    if (upper) {
      sides_.push_back({{right, row + 1}, {left, row + 1}, run});
    } else {
      sides_.push_back({{left, row}, {right, row}, run});
    }
  }

  const std::vector<ChangedRun>& runs_;
  std::vector<std::size_t> part_;
  std::vector<Side> sides_;
};

std::uint64_t KeyOf(CellIndex corner) {
  return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(corner.row)) << 32) |
         static_cast<std::uint32_t>(corner.column);
}

// > 0: `next` turns left of `side`.
int TurnOf(const Side& side, const Side& next) {
  const auto sign = [](int a, int b) { return (b > a) - (b < a); };
  return sign(side.from.column, side.to.column) * sign(next.from.row, next.to.row) -
         sign(side.from.row, side.to.row) * sign(next.from.column, next.to.column);
}

// Follows the sides from `first` on. Where cells touch at a corner, it turns left: it stays with its own cells.
CellRing FollowRing(std::size_t first, const std::unordered_multimap<std::uint64_t, std::size_t>& from,
                    std::vector<Side>& sides) {
  CellRing ring;
  for (std::size_t current = first;;) {
    Side& side = sides[current];
    side.used = true;
    const auto [begin, end] = from.equal_range(KeyOf(side.to));
    std::size_t next = sides.size();
    for (auto it = begin; it != end; ++it) {
      if (next == sides.size() || TurnOf(side, sides[it->second]) > TurnOf(side, sides[next])) next = it->second;
    }
    if (TurnOf(side, sides[next]) != 0) ring.push_back(side.to);
    if (next == first) return ring;
    current = next;
  }
}

// Twice the area; > 0: counter-clockwise.
std::int64_t DoubledArea(const CellRing& ring) {
  std::int64_t area = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const CellIndex a = ring[i];
    const CellIndex b = ring[(i + 1) % ring.size()];
    area += std::int64_t{a.column} * b.row - std::int64_t{b.column} * a.row;
  }
  return area;
}

}  // namespace

std::vector<CellPolygon> OutlinesOf(const std::vector<ChangedRun>& runs) {
  Sides outline(runs);
  std::vector<Side>& sides = outline.sides();
  std::unordered_multimap<std::uint64_t, std::size_t> from;
  from.reserve(sides.size());
  for (std::size_t i = 0; i < sides.size(); ++i) from.emplace(KeyOf(sides[i].from), i);
  std::map<std::size_t, CellPolygon> parts;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    if (sides[i].used) continue;
    CellPolygon& polygon = parts[outline.PartOf(sides[i].run)];
    CellRing ring = FollowRing(i, from, sides);
    if (DoubledArea(ring) > 0) {
      polygon.outer = std::move(ring);
    } else {
      polygon.holes.push_back(std::move(ring));
    }
  }
  std::vector<CellPolygon> polygons;
  for (auto& [run, polygon] : parts) polygons.push_back(std::move(polygon));
  return polygons;
}

}  // namespace enfilade::grid
