// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/edit/map_edit.h"
#include "core/edit/overlay.h"

namespace enfilade::edit {

using CellSet = std::set<std::pair<int, int>>;  // column, row

// Which cells a shape covers by the definitions in map_edit.h: each cell by itself, in 128 bits. Slow.
bool IsCovered(const Shape& shape, int column, int row);
CellSet CoveredCells(const Shape& shape);

// What core/edit makes of it.
CellSet DrawnCells(const Shape& shape);

// Of pictures of cells, the top row first: '.' none, '?' unknown, '-' free, '#' occupied, 'x' clear.
Instruction InstructionOf(char letter);
// The lower-left letter is the cell (column, row).
Overlay OverlayIn(const std::vector<std::string>& picture, int column = 0, int row = 0);
std::vector<std::string> PictureOf(const Overlay& overlay, const CellBox& box);
// '#' where the shape covers.
std::vector<std::string> PictureOf(const Shape& shape, const CellBox& box);

// The centres of cells.
LatticePoint Centre(int column, int row);
std::vector<LatticePoint> Centres(const std::vector<std::pair<int, int>>& cells);

}  // namespace enfilade::edit
