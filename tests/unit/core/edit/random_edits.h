// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <random>

#include "core/edit/map_edit.h"

namespace enfilade::edit {

// Shapes that Validate accepts, within about `reach` units of `at`; of `size` units, some of them small, many of them
// with points and sides exactly on centres of cells and edges of tiles.
struct RandomShapes {
  LatticePoint at;
  int reach = 20'000;
  int size = 4'000;

  Brush RandomBrush(std::mt19937& random) const;
  Line RandomLine(std::mt19937& random) const;
  Polygon RandomPolygon(std::mt19937& random) const;
  Patch RandomPatch(std::mt19937& random) const;
  Shape RandomShape(std::mt19937& random) const;

 private:
  LatticePoint RandomPoint(std::mt19937& random, LatticePoint around, int within) const;
  std::vector<LatticePoint> RandomPath(std::mt19937& random) const;
};

Instruction RandomInstruction(std::mt19937& random);  // any but kNone

}  // namespace enfilade::edit
