// SPDX-License-Identifier: Apache-2.0
#include "perception/plan/walls/wall_lines.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/prior/plan/directions.h"
#include "core/prior/plan/planar.h"
#include "perception/plan/walls/wall_directions.h"

namespace enfilade::perception {
namespace {

using Eigen::Vector2d;

class Assembly {
 public:
  explicit Assembly(const StrokeGraph& walls) : graph_(walls) {}

  prior::PlanGraph Run() {
    ContractBranchings();
    JoinLines();
    FitLines();
    PlaceJoints();
    return prior::Planarise(ToPlan(), Weld());
  }

 private:
  double MedianWidth() const {
    std::vector<double> widths;
    for (const Stroke& stroke : graph_.strokes) widths.push_back(stroke.width);
    if (widths.empty()) return 1;
    std::nth_element(widths.begin(), widths.begin() + static_cast<long>(widths.size() / 2), widths.end());
    return widths[widths.size() / 2];
  }
  double Weld() const { return std::max(1.5, 0.6 * MedianWidth()); }

  std::vector<std::vector<int>> StrokesAtJoints() const {
    std::vector<std::vector<int>> at(graph_.joints.size());
    for (std::size_t i = 0; i < graph_.strokes.size(); ++i) {
      at[graph_.strokes[i].from].push_back(static_cast<int>(i));
      at[graph_.strokes[i].to].push_back(static_cast<int>(i));
    }
    return at;
  }

  // The skeleton of a crossing of wide strokes has two branchings close to each other, and pieces around them that are
  // shorter than the strokes are wide. At the ends of wide strokes it may have hooks.
  static constexpr double kWidestCrossing = 1.5;  // times the longest piece in it

  void ContractBranchings() {
    const auto at = StrokesAtJoints();
    std::vector<double> width(graph_.joints.size(), 0);
    for (std::size_t j = 0; j < at.size(); ++j) {
      for (const int i : at[j]) width[j] = std::max(width[j], graph_.strokes[i].width);
    }
    std::vector<int> target(graph_.joints.size());
    std::iota(target.begin(), target.end(), 0);
    const auto root = [&](int j) {
      while (target[j] != j) j = target[j] = target[target[j]];
      return j;
    };
    std::vector<Eigen::AlignedBox2d> extent;
    for (const Vector2d& joint : graph_.joints) extent.emplace_back(joint);
    std::vector<std::size_t> shortest_first(graph_.strokes.size());
    std::iota(shortest_first.begin(), shortest_first.end(), 0);
    std::stable_sort(shortest_first.begin(), shortest_first.end(), [&](std::size_t a, std::size_t b) {
      return graph_.LengthOf(graph_.strokes[a]) < graph_.LengthOf(graph_.strokes[b]);
    });
    for (const std::size_t i : shortest_first) {
      const Stroke& stroke = graph_.strokes[i];
      const bool ends = at[stroke.from].size() < 2 || at[stroke.to].size() < 2;
      if (ends && at[stroke.from].size() + at[stroke.to].size() < 3) continue;  // stands alone
      const double widest = std::max(width[stroke.from], width[stroke.to]);
      const double reach = ends ? 1.4 * widest : std::max(2.0, 0.75 * widest);
      if (graph_.LengthOf(stroke) >= reach) continue;
      // Many short pieces in a row are no crossing.
      const int one = root(stroke.from), other = root(stroke.to);
      const Eigen::AlignedBox2d both = extent[one].merged(extent[other]);
      if (both.diagonal().norm() > kWidestCrossing * reach) continue;
      target[one] = other;
      extent[other] = both;
    }
    std::vector<Vector2d> sum(graph_.joints.size(), Vector2d::Zero());
    std::vector<int> count(graph_.joints.size(), 0);
    for (std::size_t j = 0; j < at.size(); ++j) {
      sum[root(static_cast<int>(j))] += graph_.joints[j];
      ++count[root(static_cast<int>(j))];
    }
    for (std::size_t j = 0; j < at.size(); ++j) {
      if (count[j] > 0) graph_.joints[j] = sum[j] / count[j];
    }
    for (Stroke& stroke : graph_.strokes) {
      stroke.from = root(stroke.from);
      stroke.to = root(stroke.to);
    }
    std::erase_if(graph_.strokes, [](const Stroke& stroke) { return stroke.from == stroke.to; });
  }

  int LineOf(int stroke) {
    while (line_[stroke] != stroke) stroke = line_[stroke] = line_[line_[stroke]];
    return stroke;
  }

  // At each joint, strokes that go on straight are one line, the straightest first, as long as one line fits them.
  void JoinLines() {
    line_.resize(graph_.strokes.size());
    std::iota(line_.begin(), line_.end(), 0);
    moments_.clear();
    for (const Stroke& stroke : graph_.strokes) moments_.push_back(stroke.moments);
    struct Pair {
      double turn;
      int one, other;
    };
    std::vector<Pair> pairs;
    for (const std::vector<int>& around : StrokesAtJoints()) {
      for (std::size_t i = 0; i < around.size(); ++i) {
        for (std::size_t j = i + 1; j < around.size(); ++j) {
          const double turn = TurnBetween(around[i], around[j]);
          const double shorter =
              std::min(graph_.LengthOf(graph_.strokes[around[i]]), graph_.LengthOf(graph_.strokes[around[j]]));
          // A short piece of a straight skeleton may turn by a pixel or two.
          if (turn < std::max(kStraight, std::min(0.4, 2.5 / shorter))) pairs.push_back({turn, around[i], around[j]});
        }
      }
    }
    std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.turn < b.turn; });
    for (const Pair& pair : pairs) JoinIfStraight(LineOf(pair.one), LineOf(pair.other));
  }

  static constexpr double kStraight = 0.14;  // rad

  double TurnBetween(int i, int j) const {
    const auto direction = [&](int k) -> Vector2d {
      const Stroke& stroke = graph_.strokes[k];
      return (graph_.joints[stroke.to] - graph_.joints[stroke.from]).normalized();
    };
    return std::acos(std::min(1.0, std::abs(direction(i).dot(direction(j)))));
  }

  void JoinIfStraight(int one, int other) {
    if (one == other) return;
    Moments both = moments_[one];
    both.Add(moments_[other]);
    const double width = std::max(graph_.strokes[one].width, graph_.strokes[other].width);
    const double loose =
        std::max({0.7, 0.08 * width, 1.3 * FitLine(moments_[one]).rms, 1.3 * FitLine(moments_[other]).rms});
    if (FitLine(both).rms > loose) return;
    line_[other] = one;
    moments_[one] = both;
  }

  void FitLines() {
    lines_.assign(graph_.strokes.size(), FittedLine());
    std::vector<prior::WeightedDirection> directions;
    std::vector<int> roots;
    for (std::size_t i = 0; i < graph_.strokes.size(); ++i) {
      if (LineOf(static_cast<int>(i)) != static_cast<int>(i)) continue;
      lines_[i] = FitLine(moments_[i]);
      directions.push_back({lines_[i].Direction(), moments_[i].count});
      roots.push_back(static_cast<int>(i));
    }
    const std::vector<double> dominant = prior::DominantDirections(directions);
    for (const int i : roots) SnapLine(dominant, moments_[i], lines_[i]);
  }

  // A joint lies on all its lines; along a single line it stays where the skeleton has it.
  void PlaceJoints() {
    const auto at = StrokesAtJoints();
    for (std::size_t j = 0; j < at.size(); ++j) {
      if (at[j].empty()) continue;
      const Vector2d start = graph_.joints[j];
      constexpr double kHold = 0.01;
      Eigen::Matrix2d information = kHold * Eigen::Matrix2d::Identity();
      Vector2d pull = kHold * start;
      std::vector<int> seen;
      double width = 0;
      for (const int i : at[j]) {
        width = std::max(width, graph_.strokes[i].width);
        const int line = LineOf(i);
        if (std::find(seen.begin(), seen.end(), line) != seen.end()) continue;
        seen.push_back(line);
        const double weight = std::clamp(moments_[line].count / 20, 0.05, 1.0);
        information += weight * lines_[line].normal * lines_[line].normal.transpose();
        pull += weight * lines_[line].offset * lines_[line].normal;
      }
      const Vector2d solved = information.inverse() * pull;
      if ((solved - start).norm() < std::max(4.0, 1.5 * width)) graph_.joints[j] = solved;
      if (at[j].size() == 1) ExtendEnd(graph_.strokes[at[j][0]], static_cast<int>(j));
    }
  }

  void ExtendEnd(const Stroke& stroke, int end) {
    const int other = stroke.from == end ? stroke.to : stroke.from;
    const Vector2d outward = (graph_.joints[end] - graph_.joints[other]).normalized();
    graph_.joints[end] += outward * (stroke.width / 2);
  }

  prior::PlanGraph ToPlan() {
    // Joints where one line goes on and nothing else begins are no corners.
    const auto at = StrokesAtJoints();
    std::vector<int> line_of(graph_.strokes.size());
    for (std::size_t i = 0; i < line_of.size(); ++i) line_of[i] = LineOf(static_cast<int>(i));
    std::vector<bool> done(graph_.strokes.size(), false);
    const auto passes = [&](int joint) {
      return at[joint].size() == 2 && at[joint][0] != at[joint][1] && line_of[at[joint][0]] == line_of[at[joint][1]];
    };
    prior::PlanGraph plan;
    for (const Vector2d& joint : graph_.joints) plan.corners.push_back({joint});
    for (std::size_t i = 0; i < graph_.strokes.size(); ++i) {
      if (done[i]) continue;
      prior::PlanWall wall;
      double length = 0, width = 0;
      const auto walk = [&](int stroke, int joint) {
        while (true) {
          if (!passes(joint)) return joint;
          const int next = at[joint][0] == stroke ? at[joint][1] : at[joint][0];
          if (done[next]) return joint;
          done[next] = true;
          length += graph_.LengthOf(graph_.strokes[next]);
          width += graph_.LengthOf(graph_.strokes[next]) * graph_.strokes[next].width;
          joint = graph_.strokes[next].from == joint ? graph_.strokes[next].to : graph_.strokes[next].from;
          stroke = next;
        }
      };
      done[i] = true;
      length = graph_.LengthOf(graph_.strokes[i]);
      width = length * graph_.strokes[i].width;
      wall.from = walk(static_cast<int>(i), graph_.strokes[i].from);
      wall.to = walk(static_cast<int>(i), graph_.strokes[i].to);
      wall.thickness = length > 0 ? width / length : 0;
      if (wall.from != wall.to) plan.walls.push_back(wall);
    }
    return plan;
  }

  StrokeGraph graph_;
  std::vector<int> line_;  // of each stroke: a stroke that stands for it
  std::vector<Moments> moments_;
  std::vector<FittedLine> lines_;
};

}  // namespace

prior::PlanGraph AssembleWalls(const StrokeGraph& walls) { return Assembly(walls).Run(); }

}  // namespace enfilade::perception
