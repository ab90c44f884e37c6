// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/core/edit/random_edits.h"

#include <algorithm>
#include <cmath>

namespace enfilade::edit {
namespace {

int RandomInt(std::mt19937& random, int from, int to) {
  return from + static_cast<int>(random() % (static_cast<std::uint32_t>(to - from) + 1U));
}

// Onto a centre or a corner of a cell, or left where it is.
int Snapped(std::mt19937& random, int units) {
  const int cell = static_cast<int>(std::floor(static_cast<double>(units) / kUnitsPerCell));
  switch (random() % 4) {
    case 0:
      return cell * kUnitsPerCell + kUnitsPerCell / 2;
    case 1:
      return cell * kUnitsPerCell;
    default:
      return units;
  }
}

}  // namespace

LatticePoint RandomShapes::RandomPoint(std::mt19937& random, LatticePoint around, int within) const {
  const int x = Snapped(random, RandomInt(random, around.x - within, around.x + within));
  const int y = Snapped(random, RandomInt(random, around.y - within, around.y + within));
  return {x, y};
}

std::vector<LatticePoint> RandomShapes::RandomPath(std::mt19937& random) const {
  const LatticePoint around = RandomPoint(random, at, reach);
  std::vector<LatticePoint> points;
  for (int i = RandomInt(random, 1, 5); i > 0; --i) {
    LatticePoint point = RandomPoint(random, around, size);
    if (!points.empty() && random() % 4 == 0) point.x = points.back().x;  // upright, level, twice the same
    if (!points.empty() && random() % 4 == 0) point.y = points.back().y;
    points.push_back(point);
  }
  return points;
}

Brush RandomShapes::RandomBrush(std::mt19937& random) const {
  static constexpr int kRadii[] = {0, 1, 90, 127, 128, 129, 181, 256, 512, 1280};
  const int radius = random() % 2 == 0 ? kRadii[random() % std::size(kRadii)] : RandomInt(random, 0, size / 2);
  Brush brush{RandomPath(random), radius};
  if (radius < kUnitsPerCell) {  // so that it covers a cell
    const int half = kUnitsPerCell / 2;
    LatticePoint& first = brush.points.front();
    first = {(first.x >> 8) * kUnitsPerCell + half, (first.y >> 8) * kUnitsPerCell + half};
  }
  return brush;
}

Line RandomShapes::RandomLine(std::mt19937& random) const { return {RandomPath(random)}; }

// Rings around points, with corners by their angle: no sides cross, but rings may.
Polygon RandomShapes::RandomPolygon(std::mt19937& random) const {
  const LatticePoint centre = RandomPoint(random, at, reach);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Polygon polygon;
  for (int rings = RandomInt(random, 1, 3); rings > 0; --rings) {
    std::vector<LatticePoint>& ring = polygon.rings.emplace_back();
    if (random() % 3 == 0) {  // a rectangle
      const LatticePoint a = RandomPoint(random, centre, size);
      const LatticePoint b = RandomPoint(random, centre, size);
      ring = {a, {b.x, a.y}, b, {a.x, b.y}};
      continue;
    }
    const int corners = RandomInt(random, 3, 9);
    const int half = kUnitsPerCell / 2;
    const bool on_centres = random() % 2 == 0;
    for (int i = 0; i < corners; ++i) {
      const double angle = 2.0 * M_PI * (i + 0.8 * unit(random)) / corners;
      const double radius = (0.3 + 0.7 * unit(random)) * size;
      LatticePoint point{centre.x + static_cast<int>(radius * std::cos(angle)),
                         centre.y + static_cast<int>(radius * std::sin(angle))};
      if (on_centres) {
        point = {(point.x >> 8) * kUnitsPerCell + half, (point.y >> 8) * kUnitsPerCell + half};
      }
      ring.push_back(point);
    }
    if (!Validate(Polygon{{ring}}).ok()) ring.resize(3);  // rounded corners of a narrow ring may cross
  }
  if (!Validate(polygon).ok()) polygon.rings = {{at, {at.x + size, at.y}, {at.x, at.y + size}}};
  return polygon;
}

Patch RandomShapes::RandomPatch(std::mt19937& random) const {
  const LatticePoint corner = RandomPoint(random, at, reach);
  const int side = std::max(2, size / kUnitsPerCell);
  Patch patch{{corner.x >> 8, corner.y >> 8, RandomInt(random, 1, side), RandomInt(random, 1, side)}, {}};
  int left = patch.box.width * patch.box.height;
  patch.runs = {0, 1};  // takes at least one
  --left;
  while (left > 0 && random() % 20 != 0) {
    const int run = RandomInt(random, 0, std::min(left, 30));
    patch.runs.push_back(static_cast<std::uint32_t>(run));
    left -= run;
  }
  return patch;
}

Shape RandomShapes::RandomShape(std::mt19937& random) const {
  switch (random() % 4) {
    case 0:
      return RandomBrush(random);
    case 1:
      return RandomLine(random);
    case 2:
      return RandomPolygon(random);
    default:
      return RandomPatch(random);
  }
}

Instruction RandomInstruction(std::mt19937& random) { return static_cast<Instruction>(1 + random() % 4); }

}  // namespace enfilade::edit
