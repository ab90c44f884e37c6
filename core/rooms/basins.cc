// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/basins.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <unordered_map>
#include <utility>

namespace enfilade::rooms {
namespace {

// Floods the open ground from the widest places down and joins basins as they meet.
class Watershed {
 public:
  Watershed(const GroundMap& ground, const DistanceField& field, const NarrowPlaces& limits)
      : ground_(ground), field_(field), limits_(limits), basin_(ground.cells.size(), -1) {}

  void Run() {
    for (const std::uint32_t cell : Descending()) Flood(cell);
    for (std::int32_t& basin : basin_) {
      if (basin >= 0) basin = Root(basin);
    }
  }

  // -1: not open.
  const std::vector<std::int32_t>& basins() const { return basin_; }

 private:
  std::vector<std::uint32_t> Descending() const {
    constexpr float kBuckets = 4.0F;  // per cell of distance
    constexpr float kMost = 4096.0F;
    std::vector<std::uint32_t> count(static_cast<std::size_t>(kBuckets * kMost) + 2, 0);
    const auto bucket = [&](std::size_t cell) {
      return static_cast<std::size_t>((kMost - std::min(field_.distance[cell], kMost)) * kBuckets);
    };
    for (std::size_t i = 0; i < basin_.size(); ++i) count[bucket(i) + 1] += ground_.IsOpen(i) ? 1 : 0;
    for (std::size_t b = 1; b < count.size(); ++b) count[b] += count[b - 1];
    std::vector<std::uint32_t> order(count.back());
    for (std::size_t i = 0; i < basin_.size(); ++i) {
      if (ground_.IsOpen(i)) order[count[bucket(i)]++] = static_cast<std::uint32_t>(i);
    }
    return order;
  }

  std::int32_t Root(std::int32_t basin) {
    while (parent_[static_cast<std::size_t>(basin)] != basin) {
      std::int32_t& up = parent_[static_cast<std::size_t>(basin)];
      up = parent_[static_cast<std::size_t>(up)];
      basin = up;
    }
    return basin;
  }

  void Flood(std::uint32_t cell) {
    const auto width = static_cast<std::size_t>(ground_.width);
    std::int32_t own = -1;
    float highest = -1.0F;
    std::array<std::int32_t, 4> around{};
    std::size_t met = 0;
    const auto look = [&](std::size_t neighbour) {
      if (basin_[neighbour] < 0) return;
      around[met] = Root(basin_[neighbour]);
      if (field_.distance[neighbour] > highest) {
        highest = field_.distance[neighbour];
        own = around[met];
      }
      ++met;
    };
    if (cell % width > 0) look(cell - 1);
    if (cell % width + 1 < width) look(cell + 1);
    if (cell >= width) look(cell - width);
    if (cell + width < basin_.size()) look(cell + width);
    const double here = field_.distance[cell];
    if (own < 0) {
      own = static_cast<std::int32_t>(parent_.size());
      parent_.push_back(own);
      peak_.push_back(here);
    }
    basin_[cell] = own;
    for (std::size_t i = 0; i < met; ++i) Meet(own, around[i], here);
  }

  void Meet(std::int32_t a, std::int32_t b, double here) {
    a = Root(a);
    b = Root(b);
    if (a == b) return;
    if (peak_[static_cast<std::size_t>(a)] < peak_[static_cast<std::size_t>(b)]) std::swap(a, b);
    const double rise = peak_[static_cast<std::size_t>(b)] - here;
    if (rise >= limits_.narrowing && here <= limits_.max_radius) return;
    parent_[static_cast<std::size_t>(b)] = a;
  }

  const GroundMap& ground_;
  const DistanceField& field_;
  const NarrowPlaces limits_;
  std::vector<std::int32_t> basin_;
  std::vector<std::int32_t> parent_;
  std::vector<double> peak_;
};

struct BorderCell {
  std::int32_t lower;
  std::int32_t upper;
  std::uint32_t cell;

  friend auto operator<=>(const BorderCell&, const BorderCell&) = default;
};

std::vector<BorderCell> BordersOf(const GroundMap& ground, const std::vector<std::int32_t>& basins) {
  std::vector<BorderCell> borders;
  const auto width = static_cast<std::size_t>(ground.width);
  const auto add = [&](std::size_t one, std::size_t other) {
    if (basins[one] < 0 || basins[other] < 0 || basins[one] == basins[other]) return;
    borders.push_back(
        {std::min(basins[one], basins[other]), std::max(basins[one], basins[other]), static_cast<std::uint32_t>(one)});
  };
  for (std::size_t i = 0; i < basins.size(); ++i) {
    if ((i + 1) % width != 0) add(i, i + 1);
    if (i + width < basins.size()) add(i, i + width);
  }
  std::sort(borders.begin(), borders.end());
  borders.erase(std::unique(borders.begin(), borders.end()), borders.end());
  return borders;
}

// The widest cell of each connected stretch of the border of two basins, `begin` to `end`.
void AddWidest(const GroundMap& ground, const DistanceField& field, std::span<const BorderCell> border,
               std::vector<std::size_t>& places) {
  constexpr int kReach = 2;
  std::unordered_map<std::uint32_t, bool> seen;
  for (const BorderCell& entry : border) seen.emplace(entry.cell, false);
  for (const BorderCell& entry : border) {
    if (seen[entry.cell]) continue;
    seen[entry.cell] = true;
    std::vector<std::uint32_t> stretch{entry.cell};
    std::size_t widest = entry.cell;
    for (std::size_t next = 0; next < stretch.size(); ++next) {
      const auto column = static_cast<int>(stretch[next] % static_cast<std::uint32_t>(ground.width));
      const auto row = static_cast<int>(stretch[next] / static_cast<std::uint32_t>(ground.width));
      if (field.distance[stretch[next]] > field.distance[widest]) widest = stretch[next];
      for (int y = row - kReach; y <= row + kReach; ++y) {
        for (int x = column - kReach; x <= column + kReach; ++x) {
          if (!ground.contains(x, y)) continue;
          const auto found = seen.find(static_cast<std::uint32_t>(ground.index(x, y)));
          if (found == seen.end() || found->second) continue;
          found->second = true;
          stretch.push_back(found->first);
        }
      }
    }
    places.push_back(widest);
  }
}

}  // namespace

std::vector<std::size_t> FindNarrowPlaces(const GroundMap& ground, const DistanceField& field,
                                          const NarrowPlaces& limits) {
  Watershed watershed(ground, field, limits);
  watershed.Run();
  const std::vector<BorderCell> borders = BordersOf(ground, watershed.basins());
  std::vector<std::size_t> places;
  for (std::size_t begin = 0, end = 0; begin < borders.size(); begin = end) {
    while (end < borders.size() && borders[end].lower == borders[begin].lower &&
           borders[end].upper == borders[begin].upper) {
      ++end;
    }
    AddWidest(ground, field, std::span(borders).subspan(begin, end - begin), places);
  }
  return places;
}

}  // namespace enfilade::rooms
