// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/grid/diff/map_diff.h"

namespace enfilade::grid {

struct DiffLattice;

// Draws two rasters as one picture (MapDiffOptions::with_picture).
class DiffPicture {
 public:
  DiffPicture(const DiffLattice& lattice, int max_side);

  // As DiffSweep::Add.
  void Add(int row, int column, const std::uint8_t* base, const std::uint8_t* revision, int size);
  MapDiffPicture Finish() &&;

 private:
  int shift_ = 0;   // a pixel stands for 2^shift x 2^shift cells
  int left_ = 0;    // the lattice's least column
  int bottom_ = 0;  // ... and row
  int last_column_ = 0;
  int last_row_ = 0;
  int width_ = 0;  // pixels
  int height_ = 0;
  Pose2 T_map_picture_;
  std::vector<std::uint8_t> ranks_;  // of each pixel, rows upwards
};

}  // namespace enfilade::grid
