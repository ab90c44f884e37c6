// SPDX-License-Identifier: Apache-2.0
#include "perception/plan/walls/wall_selection.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "core/geometry/convex_hull.h"
#include "perception/plan/walls/door_swings.h"
#include "perception/plan/walls/weighted_median.h"

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
      if (!pens_.empty()) DropAnnotations();
      if (widest > 0 && !pens_.empty() && !IsStructural(thinnest, widest)) {
        thin_pen_ = std::max(thin_pen_, widest);
        ForEachKept([&](std::size_t i) {
          if (Width(i) >= thinnest && Width(i) <= widest) kept_[i] = false;
        });
      } else {
        pens_.emplace_back(thinnest, widest);
      }
    }
    DropSwings();
    DropSmallParts(kFurnitureShare, kSymbolShare);
    return kept_;
  }

  double thin_pen() const { return thin_pen_; }
  // 0 if there is none.
  double ThinnestWall() const {
    double thinnest = 0;
    for (const auto& [from, to] : pens_) {
      if (from > thin_pen_ && (thinnest == 0 || from < thinnest)) thinnest = from;
    }
    return thinnest;
  }

 private:
  static constexpr double kSymbolShare = 0.025;    // of the diagonal: letters and signs are smaller
  static constexpr double kFurnitureShare = 0.06;  // things that stand alone
  static constexpr double kWideShare = 0.6;        // of the usual width
  static constexpr double kLongShare = 0.03;       // a line that is long; it has at least
  static constexpr double kLongRun = 0.3;          // of the length of a usual wall, too
  static constexpr double kLeastHull = 0.5;        // of the hull of all strokes
  static constexpr double kHullMargin = 0.01;      // of the diagonal
  static constexpr double kMuchThinner = 0.4;      // than walls usually are
  static constexpr double kTickShare = 0.012;      // of the diagonal: ticks, arrows and parts of digits are shorter
  static constexpr int kFewestTicks = 2;
  static constexpr double kStructuralShare = 0.5;  // of a pen's length, in long lines that begin and end at others

  // Walls are drawn with the widest pen, or some with a thinner one, with which other things are drawn, too.
  void DropSwings() {
    if (pens_.size() < 2) return;
    std::vector<bool> thin = kept_;
    for (std::size_t i = 0; i < thin.size(); ++i) thin[i] = thin[i] && Width(i) > 0 && Width(i) < pens_.front().first;
    const std::vector<bool> swings = FindSwings(drawing_, thin, diagonal_);
    for (std::size_t i = 0; i < kept_.size(); ++i) kept_[i] = kept_[i] && !swings[i];
  }

  // Dimension lines and other annotations are drawn with much thinner lines around the walls. They hang together with
  // ticks, arrows and digits, which have short free ends; glass, and walls that are drawn thinner, do not. Nothing is
  // dropped if the walls found so far are a small part of the drawing.
  void DropAnnotations() {
    const auto is_wall = [&](std::size_t i) { return kept_[i] && IsOfPens(i); };
    const ConvexHull walls = HullOf(is_wall);
    if (walls.Area() < kLeastHull * HullOf([&](std::size_t i) { return kept_[i]; }).Area()) return;
    const double thin = kMuchThinner * UsualWidth(is_wall), tick = kTickShare * diagonal_;
    std::vector<bool> outside(kept_.size());
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      const Stroke& stroke = drawing_.strokes[i];
      const Vector2d middle = (drawing_.joints[stroke.from] + drawing_.joints[stroke.to]) / 2;
      const bool is_thin = Width(i) > 0 && (Width(i) <= thin || Length(i) <= tick);  // ticks are blots
      outside[i] = kept_[i] && is_thin && !is_wall(i) && !walls.Contains(middle, kHullMargin * diagonal_);
    }
    DropWithTicks(outside, tick);
  }

  void DropWithTicks(const std::vector<bool>& suspects, double tick) {
    Groups groups(drawing_.joints.size());
    std::vector<int> degree(drawing_.joints.size(), 0);
    ForEachKept([&](std::size_t i) {
      const Stroke& stroke = drawing_.strokes[i];
      ++degree[stroke.from], ++degree[stroke.to];
      if (suspects[i]) groups.Join(stroke.from, stroke.to);
    });
    std::vector<int> ticks(drawing_.joints.size(), 0);
    ForEachKept([&](std::size_t i) {
      const Stroke& stroke = drawing_.strokes[i];
      const bool ends = std::min(degree[stroke.from], degree[stroke.to]) == 1;
      if (suspects[i] && ends && Length(i) <= tick) ++ticks[groups.RootOf(stroke.from)];
    });
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      if (suspects[i] && ticks[groups.RootOf(drawing_.strokes[i].from)] >= kFewestTicks) kept_[i] = false;
    }
  }

  template <typename Among>
  ConvexHull HullOf(const Among& among) const {
    std::vector<Vector2d> points;
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      if (!among(i)) continue;
      points.push_back(drawing_.joints[drawing_.strokes[i].from]);
      points.push_back(drawing_.joints[drawing_.strokes[i].to]);
    }
    return ConvexHull(std::move(points));
  }

  double Width(std::size_t i) const { return drawing_.strokes[i].width; }
  double Length(std::size_t i) const { return drawing_.LengthOf(drawing_.strokes[i]); }

  template <typename Use>
  void ForEachKept(const Use& use) {
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      if (kept_[i]) use(i);
    }
  }

  // Drops connected parts smaller than `share` of the diagonal; those drawn as wide as most walls only if they are
  // smaller than `wide_share`.
  void DropSmallParts(double share, double wide_share) {
    struct Part {
      Box box;
      double length = 0;
      double area = 0;
    };
    Groups groups(drawing_.joints.size());
    ForEachKept([&](std::size_t i) { groups.Join(drawing_.strokes[i].from, drawing_.strokes[i].to); });
    std::vector<Part> parts(drawing_.joints.size());
    ForEachKept([&](std::size_t i) {
      Part& part = parts[groups.RootOf(drawing_.strokes[i].from)];
      part.box.Add(drawing_.joints[drawing_.strokes[i].from]);
      part.box.Add(drawing_.joints[drawing_.strokes[i].to]);
      part.length += Length(i);
      part.area += Length(i) * Width(i);
    });
    const double wide = kWideShare * UsualWidth([&](std::size_t i) { return kept_[i]; });
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      const Part& part = parts[groups.RootOf(drawing_.strokes[i].from)];
      const double least = part.area >= wide * part.length ? wide_share : share;
      if (kept_[i] && part.box.Side() < least * diagonal_) kept_[i] = false;
    }
  }

  // The median along some strokes.
  template <typename Among>
  double UsualWidth(const Among& among) const {
    std::vector<std::pair<double, double>> widths;  // width, length
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      if (among(i)) widths.emplace_back(Width(i), Length(i));
    }
    return WeightedMedian(std::move(widths));
  }

  // The ranges of width that the kept strokes fall into, the widest first.
  std::vector<std::pair<double, double>> PensOf(const std::vector<bool>& kept) const {
    std::vector<std::pair<double, double>> sorted;  // width, length
    for (std::size_t i = 0; i < kept.size(); ++i) {
      if (kept[i]) sorted.emplace_back(Width(i), Length(i));
    }
    std::sort(sorted.begin(), sorted.end());
    std::vector<std::pair<double, double>> pens;
    Divide(sorted, 0, sorted.size(), pens);
    std::sort(pens.rbegin(), pens.rend());
    return pens;
  }

  // Otsu's division of the widths' logarithms, weighted by length, as long as the parts' means differ enough.
  static void Divide(const std::vector<std::pair<double, double>>& sorted, std::size_t first, std::size_t last,
                     std::vector<std::pair<double, double>>& pens) {
    if (first >= last) return;
    constexpr double kLeastRatio = 1.8;
    const auto value = [&](std::size_t i) { return std::log(std::max(0.5, sorted[i].first)); };
    double total = 0, sum = 0;
    for (std::size_t i = first; i < last; ++i) total += sorted[i].second, sum += sorted[i].second * value(i);
    double below = 0, sum_below = 0, best = 0, best_ratio = 1;
    std::size_t cut = first;
    for (std::size_t i = first; i + 1 < last; ++i) {
      below += sorted[i].second;
      sum_below += sorted[i].second * value(i);
      if (sorted[i].first == sorted[i + 1].first || below <= 0 || below >= total) continue;
      const double apart = (sum - sum_below) / (total - below) - sum_below / below;
      const double between = below * (total - below) * apart * apart;
      if (between <= best) continue;
      best = between;
      best_ratio = std::exp(apart);
      cut = i + 1;
    }
    if (cut == first || best_ratio < kLeastRatio) {
      pens.emplace_back(sorted[first].first, sorted[last - 1].first);
      return;
    }
    Divide(sorted, first, cut, pens);
    Divide(sorted, cut, last, pens);
  }

  bool IsOfPens(std::size_t i) const {
    return std::any_of(pens_.begin(), pens_.end(),
                       [&](const auto& pen) { return Width(i) >= pen.first && Width(i) <= pen.second; });
  }

  // Strokes that go on straight through joints, as one.
  struct Runs {
    std::vector<int> of;  // the run of each stroke
    std::vector<double> length;
    std::vector<int> open_ends;  // that no other stroke touches
  };

  template <typename Among>
  Runs FindRuns(const Among& among) const {
    std::vector<std::vector<std::size_t>> at(drawing_.joints.size());
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      if (!among(i)) continue;
      at[drawing_.strokes[i].from].push_back(i);
      at[drawing_.strokes[i].to].push_back(i);
    }
    Groups groups(kept_.size());
    std::vector<int> open(kept_.size(), 0);
    for (const std::vector<std::size_t>& around : at) {
      if (around.size() == 1) ++open[around[0]];
      for (std::size_t i = 0; i < around.size(); ++i) {
        for (std::size_t j = i + 1; j < around.size(); ++j) {
          if (Continues(around[i], around[j])) groups.Join(static_cast<int>(around[i]), static_cast<int>(around[j]));
        }
      }
    }
    Runs runs{std::vector<int>(kept_.size()), std::vector<double>(kept_.size(), 0), std::vector<int>(kept_.size(), 0)};
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      runs.of[i] = groups.RootOf(static_cast<int>(i));
      if (!among(i)) continue;
      runs.length[runs.of[i]] += Length(i);
      runs.open_ends[runs.of[i]] += open[i];
    }
    return runs;
  }

  // Half of the length of all walls accepted so far is in runs at least as long.
  double UsualRun() const {
    const auto accepted = [&](std::size_t i) { return kept_[i] && IsOfPens(i); };
    const Runs runs = FindRuns(accepted);
    std::vector<double> lengths;
    double total = 0;
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      if (accepted(i) && runs.of[i] == static_cast<int>(i)) lengths.push_back(runs.length[i]);
    }
    std::sort(lengths.rbegin(), lengths.rend());
    for (const double length : lengths) total += length;
    double above = 0;
    for (const double length : lengths) {
      above += length;
      if (above >= total / 2) return length;
    }
    return 0;
  }

  // Whether a pen draws mostly long lines between other lines.
  bool IsStructural(double thinnest, double widest) const {
    const auto of_pen = [&](std::size_t i) { return kept_[i] && Width(i) >= thinnest && Width(i) <= widest; };
    const Runs runs = FindRuns([&](std::size_t i) { return of_pen(i) || (kept_[i] && IsOfPens(i)); });
    const double is_long = std::max(kLongShare * diagonal_, kLongRun * UsualRun());
    double all = 0, structural = 0;
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      if (!of_pen(i)) continue;
      all += Length(i);
      if (runs.length[runs.of[i]] >= is_long && runs.open_ends[runs.of[i]] < 2) structural += Length(i);
    }
    return all > 0 && structural >= kStructuralShare * all;
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

SelectedStrokes SelectWalls(const StrokeGraph& drawing, double diagonal) {
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
