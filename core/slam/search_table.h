#pragma once

#include <cstdint>
#include <vector>

#include "core/slam/cell_window.h"
#include "core/slam/likelihood_field.h"

namespace enfilade {

// A likelihood field as bytes, and bounds on it for branch and bound: level k's entry (i, j) is the largest likelihood
// in the cells [i 2^k, (i + 2) 2^k) x [j 2^k, (j + 2) 2^k), so that one look bounds the likelihood of a point under
// all offsets of a block of 2^k x 2^k cells (Olson 2015, "M3RSM"; Hess et al. 2016). Level 0 is the likelihood itself.
class SearchTable {
 public:
  // `sigma` (m): the likelihood is exp(-d^2 / (2 sigma^2)).
  SearchTable(double sigma, int levels);

  // Makes the table that of `field` again after `changed` of it changed.
  void Update(const LikelihoodField& field, const CellWindow& changed);

  int levels() const { return static_cast<int>(levels_.size()); }
  double resolution() const { return resolution_; }

  // Bytes of memory held.
  std::size_t bytes() const;

  // 0..255; 0 outside.
  int At(int level, int column, int row) const {
    const Level& l = levels_[static_cast<std::size_t>(level)];
    return l.window.contains(column, row) ? l.cells[l.window.index(column, row)] : 0;
  }

 private:
  struct Level {
    CellWindow window;
    std::vector<std::uint8_t> cells;
  };

  void Cover(const CellWindow& field_window);
  void UpdateLikelihoods(const LikelihoodField& field, const CellWindow& changed);
  void UpdateBounds(int level, const CellWindow& changed);

  double sigma_;
  double resolution_ = 0.05;
  std::vector<Level> blocks_;  // level k: the largest likelihood in the block of 2^k x 2^k cells
  std::vector<Level> levels_;
};

}  // namespace enfilade
