// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/slam/matching/cell_window.h"
#include "core/slam/matching/likelihood_field.h"

namespace enfilade::localization {

// Upper bounds on the likelihoods of a field for branch and bound over a whole map: entry (c, r) of level k is the
// largest likelihood, 0..255, of the cells [c, c + 2^k) x [r, r + 2^k), for every c and r (Hess et al. 2016). The
// blocks are half as wide as those of slam::SearchTable, so the bounds are tighter; but every level has all cells, and
// the table cannot be updated.
class BoundTable {
 public:
  BoundTable() = default;
  // `sigma` (m): the likelihood is exp(-d^2 / (2 sigma^2)).
  BoundTable(const slam::LikelihoodField& field, double sigma, int levels);

  int levels() const { return static_cast<int>(levels_.size()); }
  double resolution() const { return resolution_; }
  std::size_t bytes() const;

  // One level, for fast access.
  struct View {
    const std::uint8_t* cells;
    int left;
    int bottom;
    unsigned width;
    unsigned height;

    // 0 outside.
    int At(int column, int row) const {
      const auto c = static_cast<unsigned>(column - left);  // negative becomes huge
      const auto r = static_cast<unsigned>(row - bottom);
      return c < width && r < height ? cells[static_cast<std::size_t>(r) * width + c] : 0;
    }
  };
  View ViewOf(int level) const;

 private:
  struct Level {
    slam::CellWindow window;
    std::vector<std::uint8_t> cells;
  };

  double resolution_ = 0.0;
  std::vector<Level> levels_;
};

}  // namespace enfilade::localization
