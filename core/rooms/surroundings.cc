// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/surroundings.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace enfilade::rooms {
namespace {

struct Region {
  double diameter = 0.0;  // cells
  double area = 0.0;      // cells
  double outline = 0.0;   // cells
  double doors = 0.0;     // cells, the lengths of lines at it that rather are doors
  double open = 0.0;      // cells, of the others
};

std::vector<Region> MeasureRegions(const GroundMap& ground, const CutGround& cut, const std::vector<DoorLine>& lines) {
  const std::vector<std::int32_t>& region = cut.map.region;
  std::vector<Region> regions(cut.map.sizes.size());
  const auto width = static_cast<std::size_t>(ground.width);
  std::vector<std::uint8_t> bounds(region.size(), 0);
  const auto part = [&](std::size_t one, std::size_t other) {
    if (region[one] == region[other]) return;
    for (const std::size_t cell : {one, other}) {
      if (region[cell] >= 0) regions[static_cast<std::size_t>(region[cell])].outline += 1.0;
    }
    if (region[one] >= 0 && region[other] >= 0) bounds[one] = 1;
  };
  for (std::size_t i = 0; i < region.size(); ++i) {
    if (region[i] < 0) bounds[i] = 1;
    if ((i + 1) % width != 0) part(i, i + 1);
    if (i + width < region.size()) part(i, i + width);
  }
  const DistanceField field = grid::DistancesTo(bounds, ground.width, ground.height);
  for (std::size_t i = 0; i < region.size(); ++i) {
    if (region[i] < 0) continue;
    Region& own = regions[static_cast<std::size_t>(region[i])];
    own.area += 1.0;
    own.diameter = std::max(own.diameter, 2.0 * static_cast<double>(field.distance[i]));
  }
  for (std::size_t k = 0; k < lines.size(); ++k) {
    for (const std::int32_t side : {cut.sides[k].before, cut.sides[k].behind}) {
      if (side < 0) continue;
      Region& own = regions[static_cast<std::size_t>(side)];
      (lines[k].openness < 0.0 ? own.doors : own.open) += lines[k].line.length();
    }
  }
  return regions;
}

// The line that is rather a door on each cell, from 1; 0: none.
std::vector<std::size_t> DoorsAt(const GroundMap& ground, const std::vector<DoorLine>& lines) {
  std::vector<std::size_t> door(ground.cells.size(), 0);
  for (std::size_t k = 0; k < lines.size(); ++k) {
    if (lines[k].openness >= 0.0) continue;
    VisitLineCells(ground, lines[k].line, [&](std::size_t cell) { door[cell] = k + 1; });
  }
  return door;
}

}  // namespace

std::vector<Surroundings> SurroundingsOf(const GroundMap& ground, const CutGround& cut,
                                         const std::vector<DoorLine>& lines) {
  const std::vector<Region> regions = MeasureRegions(ground, cut, lines);
  const std::vector<std::size_t> doors = DoorsAt(ground, lines);
  const double cell = ground.resolution;
  const std::vector<LineContext> contexts = ContextsOf(ground, cut, lines);
  std::vector<Surroundings> surroundings;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const DoorLine& line = lines[k];
    const auto side_at = [&](std::int32_t region, double sign) {
      LineSide side;
      side.wider = WidthBeyond(ground, line.line, sign, [&](std::size_t at) {
        return ground.IsOpen(at) && (doors[at] == 0 || doors[at] == k + 1);
      });
      if (region < 0) return side;
      Region own = regions[static_cast<std::size_t>(region)];
      (line.openness < 0.0 ? own.doors : own.open) -= line.line.length();
      side.diameter = own.diameter * cell;
      side.area = own.area * cell * cell;
      side.outline = own.outline * cell;
      side.door_share = own.doors / std::max(1.0, own.outline);
      side.open_share = own.open / std::max(1.0, own.outline);
      return side;
    };
    LineSides sides{side_at(cut.sides[k].before, 1.0), side_at(cut.sides[k].behind, -1.0)};
    const auto size = [](const LineSide& side) { return std::pair(side.diameter, side.area); };
    if (size(sides[1]) < size(sides[0])) std::swap(sides[0], sides[1]);
    LineContext context = contexts[k];
    context.outline = std::min(sides[0].outline, sides[1].outline);
    surroundings.push_back({sides, context});
  }
  return surroundings;
}

SurroundedValues ValuesOf(const DoorLine& line, const Surroundings& surroundings) {
  constexpr double kMostArea = 100.0;    // m^2
  constexpr double kLeastLength = 0.05;  // m: both ends of a line may lie in one cell
  const double length = std::max(line.evidence.length, kLeastLength);
  const DoorValues own = ValuesOf(line.evidence);
  SurroundedValues all{};
  auto next = std::copy(own.begin(), own.end(), all.begin());
  for (const LineSide& side : surroundings.sides) {
    const std::array<double, kValuesOfSide> values{
        side.diameter,   side.diameter / length, std::sqrt(std::min(side.area, kMostArea)),
        side.door_share, side.open_share,        side.wider};
    next = std::copy(values.begin(), values.end(), next);
  }
  const ContextValues context = ValuesOf(surroundings.context);
  std::copy(context.begin(), context.end(), next);
  return all;
}

}  // namespace enfilade::rooms
