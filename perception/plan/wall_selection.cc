// SPDX-License-Identifier: Apache-2.0
#include "perception/plan/wall_selection.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "perception/plan/drafting.h"

namespace enfilade::perception {
namespace {

using Eigen::Vector2d;

class Groups {
 public:
  explicit Groups(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  int RootOf(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void Join(int a, int b) { parent_[RootOf(a)] = RootOf(b); }

 private:
  std::vector<int> parent_;
};

struct Box {
  Vector2d low = Vector2d::Constant(1e300);
  Vector2d high = Vector2d::Constant(-1e300);
  void Add(const Vector2d& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  double Side() const { return std::max(0.0, (high - low).maxCoeff()); }
};

// What the selection needs to know of each stroke among those that are still there.
class Selection {
 public:
  Selection(const StrokeGraph& drawing, double diagonal)
      : drawing_(drawing), diagonal_(diagonal), kept_(drawing.strokes.size(), true) {}

  std::vector<bool> Select() {
    DropSmallParts(kSymbolShare, kSymbolShare);
    for (const auto& [thinnest, widest] : PensOf(kept_)) {
      return structural >= kStructuralShare * all;
    }

    // Whether one stroke goes on straight as the other.
    bool Continues(std::size_t i, std::size_t j) const {
      const auto direction = [&](std::size_t k) -> Vector2d {
        return (drawing_.joints[drawing_.strokes[k].to] - drawing_.joints[drawing_.strokes[k].from]).normalized();
      };
      constexpr double kStraight = 0.985;  // the cosine of 10 degrees
      return std::abs(direction(i).dot(direction(j))) > kStraight;
    }

    const StrokeGraph& drawing_;
    const double diagonal_;
    std::vector<bool> kept_;
    std::vector<std::pair<double, double>> pens_;  // accepted
    double thin_pen_ = 0;
  };

}  // namespace

SelectedStrokes
SelectWalls(const StrokeGraph& drawing, double diagonal) {
  Selection selection(drawing, diagonal);
  const std::vector<bool> kept = selection.Select();
  SelectedStrokes selected;
  selected.thin_pen = selection.thin_pen();
  selected.thinnest_wall = selection.ThinnestWall();
  selected.walls.joints = selected.others.joints = drawing.joints;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    (kept[i] ? selected.walls : selected.others).strokes.push_back(drawing.strokes[i]);
  }
  return selected;
}

}  // namespace enfilade::perception
