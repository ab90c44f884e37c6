// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/slam/matching/cell_window.h"
#include "core/slam/matching/likelihood_field.h"

namespace enfilade::slam {

// A likelihood field as bytes, and upper bounds on it for branch and bound (Olson 2015, "M3RSM"; Hess et al. 2016).
// Level 0 is the likelihood itself. Entry (i, j) of level k > 0 is the largest likelihood in the cells
// [i 2^k, (i + 2) 2^k) x [j 2^k, (j + 2) 2^k): one entry bounds the likelihood of a point under all offsets of a block
// of 2^k x 2^k cells.
class SearchTable {
 public:
  // `sigma` (m): the likelihood is exp(-d^2 / (2 sigma^2)).
  SearchTable(double sigma, int levels);

  // Brings the table up to date with `field` after the window `changed` of it has changed.
  void Update(const LikelihoodField& field, const CellWindow& changed);

  int levels() const { return static_cast<int>(levels_.size()); }
  double resolution() const { return resolution_; }

  // Bytes of memory held.
  std::size_t bytes() const;

  // One level, for fast access; valid until the next Update.
  struct View {
    const std::uint8_t* cells;
    grid::CellIndex min;
    unsigned width;
    unsigned height;

    // 0..255; 0 outside.
    int At(int column, int row) const {
      const auto c = static_cast<unsigned>(column - min.column);  // negative becomes huge
      const auto r = static_cast<unsigned>(row - min.row);
      return c < width && r < height ? cells[static_cast<std::size_t>(r) * width + c] : 0;
    }
  };
  View ViewOf(int level) const {
    const Level& l = levels_[static_cast<std::size_t>(level)];
    return {l.cells.data(), l.window.min, static_cast<unsigned>(l.window.width),
            static_cast<unsigned>(l.window.height)};
  }

 private:
  struct Level {
    CellWindow window;
    std::vector<std::uint8_t> cells;
  };

  void Cover(const CellWindow& field_window);
  void UpdateLikelihoods(const LikelihoodField& field, const CellWindow& changed);
  void UpdateBounds(int level, const CellWindow& changed);
  static void MaxOfSquares(const Level& source, int step, const CellWindow& cells, Level& target);

  double sigma_;
  double resolution_ = 0.05;
  std::vector<Level> blocks_;  // level k: the largest likelihood in each block of 2^k x 2^k cells
  std::vector<Level> levels_;
};

}  // namespace enfilade::slam
