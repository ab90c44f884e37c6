// SPDX-License-Identifier: Apache-2.0
#include "perception/plan/drafting.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

namespace enfilade::perception {
namespace {

using Eigen::Vector2d;

// The strokes among some, by the joints at their ends.
class Network {
 public:
  Network(const StrokeGraph& drawing, const std::vector<bool>& among) : drawing_(drawing), at_(drawing.joints.size()) {
    for (std::size_t i = 0; i < drawing.strokes.size(); ++i) {
      if (!among[i]) continue;
      at_[drawing.strokes[i].from].push_back(static_cast<int>(i));
      at_[drawing.strokes[i].to].push_back(static_cast<int>(i));
    }
  }

  const std::vector<int>& At(int joint) const { return at_[joint]; }
  double Length(int stroke) const { return drawing_.LengthOf(drawing_.strokes[stroke]); }
  int OtherEnd(int stroke, int joint) const {
    const Stroke& s = drawing_.strokes[stroke];
    return s.from == joint ? s.to : s.from;
  }
  bool IsOpen(int stroke) const {
    return at_[drawing_.strokes[stroke].from].size() == 1 || at_[drawing_.strokes[stroke].to].size() == 1;
  }
  Vector2d DirectionFrom(int joint, int stroke) const {
    return (drawing_.joints[OtherEnd(stroke, joint)] - drawing_.joints[joint]).normalized();
  }
  // From one stroke to the next at a joint: radians, left positive.
  double TurnAt(int joint, int from, int to) const {
    const Vector2d a = -DirectionFrom(joint, from), b = DirectionFrom(joint, to);
    return std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
  }

 private:
  const StrokeGraph& drawing_;
  std::vector<std::vector<int>> at_;
};

struct Arc {
  std::vector<int> strokes;
  int from = 0, to = 0;  // joints
  double turn = 0;       // rad
  double radius = 0;     // px
};

// The arc that begins with a stroke at a joint: pieces that go on turning to one side, with nothing between them.
Arc FollowArc(const Network& network, int stroke, int joint) {
  constexpr double kLeastTurn = 0.12, kMostTurn = 1.05;  // rad, of one piece against the next
  Arc arc{.strokes = {stroke}, .from = joint, .to = network.OtherEnd(stroke, joint), .turn = 0, .radius = 0};
  double length = network.Length(stroke);
  while (network.At(arc.to).size() == 2 && arc.to != arc.from) {
    const int next = network.At(arc.to)[0] == arc.strokes.back() ? network.At(arc.to)[1] : network.At(arc.to)[0];
    const double turn = network.TurnAt(arc.to, arc.strokes.back(), next);
    if (std::abs(turn) < kLeastTurn || std::abs(turn) > kMostTurn || turn * arc.turn < 0) break;
    constexpr double kLongestPiece = 3;  // times the mean
    const double mean = length / static_cast<double>(arc.strokes.size());
    if (network.Length(next) > kLongestPiece * mean || mean > kLongestPiece * network.Length(next)) break;
    arc.turn += turn;
    length += network.Length(next);
    arc.strokes.push_back(next);
    arc.to = network.OtherEnd(next, arc.to);
  }
  const auto pieces = static_cast<double>(arc.strokes.size());
  if (arc.strokes.size() > 1) arc.radius = length * (pieces - 1) / (pieces * std::abs(arc.turn));
  return arc;
}

// Joints that lie together, and what ends there.
class Ticks {
 public:
  Ticks(const StrokeGraph& drawing, const std::vector<bool>& among, const Network& network, double diagonal)
      : network_(network), root_(drawing.joints.size()), stubs_(drawing.joints.size()) {
    constexpr double kTogether = 0.004, kStub = 0.01;  // of the diagonal
    std::iota(root_.begin(), root_.end(), 0);
    for (std::size_t i = 0; i < among.size(); ++i) {
      const int stroke = static_cast<int>(i);
      if (among[i] && !network.IsOpen(stroke) && network.Length(stroke) < kTogether * diagonal) {
        root_[RootOf(drawing.strokes[i].from)] = RootOf(drawing.strokes[i].to);
      }
    }
    for (std::size_t i = 0; i < among.size(); ++i) {
      const int stroke = static_cast<int>(i);
      if (!among[i] || !network.IsOpen(stroke) || network.Length(stroke) >= kStub * diagonal) continue;
      const int closed =
          network.At(drawing.strokes[i].from).size() > 1 ? drawing.strokes[i].from : drawing.strokes[i].to;
      stubs_[RootOf(closed)].push_back(stroke);
    }
  }

  bool IsTick(int joint) {
    constexpr std::size_t kFewestStubs = 3;
    return stubs_[RootOf(joint)].size() >= kFewestStubs;
  }
  int RootOf(int joint) {
    while (root_[joint] != joint) joint = root_[joint] = root_[root_[joint]];
    return joint;
  }
  const std::vector<int>& StubsAt(int joint) { return stubs_[RootOf(joint)]; }

  // The strokes straight on from a joint to the next tick; nullopt: the line ends without one.
  std::optional<std::vector<int>> WayToTick(int joint, int stroke) {
    constexpr double kStraight = 0.1;  // rad
    std::vector<int> way{stroke};
    const int start = RootOf(joint);
    const Vector2d direction = network_.DirectionFrom(joint, stroke);
    int end = network_.OtherEnd(stroke, joint);
    for (int steps = 0; steps < 200; ++steps) {
      if (RootOf(end) != start && IsTick(end)) return way;
      int next = -1;
      double least = kStraight;
      for (const int other : network_.At(end)) {
        if (other == way.back()) continue;
        const double turn = std::acos(std::clamp(network_.DirectionFrom(end, other).dot(direction), -1.0, 1.0));
        if (turn < least) least = turn, next = other;
      }
      if (next < 0) return std::nullopt;
      way.push_back(next);
      end = network_.OtherEnd(next, end);
    }
    return std::nullopt;
  }

 private:
  const Network& network_;
  std::vector<int> root_;
  std::vector<std::vector<int>> stubs_;
};

}  // namespace

std::vector<bool> FindSwings(const StrokeGraph& drawing, const std::vector<bool>& among, double diagonal) {
  constexpr double kLargestRadius = 0.03;  // of the diagonal
  constexpr double kLeastTurn = 0.8;       // rad
  constexpr std::size_t kFewestPieces = 4;
  const Network network(drawing, among);
  std::vector<bool> swings(among.size(), false);
  for (std::size_t i = 0; i < among.size(); ++i) {
    if (!among[i]) continue;
    for (const int begin : {drawing.strokes[i].from, drawing.strokes[i].to}) {
      const Arc arc = FollowArc(network, static_cast<int>(i), begin);
      if (arc.strokes.size() < kFewestPieces || std::abs(arc.turn) < kLeastTurn) continue;
      if (arc.radius > kLargestRadius * diagonal) continue;
      for (const int stroke : arc.strokes) swings[stroke] = true;
      for (const int end : {arc.from, arc.to}) {
        for (const int leaf : network.At(end)) {
          if (std::abs(std::log(network.Length(leaf) / arc.radius)) < std::log(1.25)) swings[leaf] = true;
        }
      }
    }
  }
  return swings;
}

std::vector<bool> FindDimensions(const StrokeGraph& drawing, const std::vector<bool>& among, double diagonal) {
  constexpr double kShortest = 0.03;  // of the diagonal
  const Network network(drawing, among);
  Ticks ticks(drawing, among, network, diagonal);
  std::vector<bool> dimensions(among.size(), false);
  std::vector<int> ends;  // joints at the ends of dimensions
  const int joints = static_cast<int>(drawing.joints.size());
  for (int joint = 0; joint < joints; ++joint) {
    if (network.At(joint).empty() || !ticks.IsTick(joint)) continue;
    for (const int stroke : network.At(joint)) {
      if (network.IsOpen(stroke)) continue;
      const std::optional<std::vector<int>> way = ticks.WayToTick(joint, stroke);
      if (!way) continue;
      double length = 0;
      for (const int piece : *way) length += network.Length(piece);
      if (length < kShortest * diagonal) continue;
      for (const int piece : *way) dimensions[piece] = true;
      ends.push_back(ticks.RootOf(joint));
    }
  }
  for (int joint = 0; joint < joints; ++joint) {
    if (network.At(joint).empty() || std::find(ends.begin(), ends.end(), ticks.RootOf(joint)) == ends.end()) continue;
    for (const int stub : ticks.StubsAt(joint)) dimensions[stub] = true;
    for (int stroke : network.At(joint)) {
      int end = network.OtherEnd(stroke, joint);
      dimensions[stroke] = true;
      // On to what is measured: where the line meets others.
      while (network.At(end).size() == 2) {
        const int next = network.At(end)[0] == stroke ? network.At(end)[1] : network.At(end)[0];
        constexpr double kStraight = 0.2;  // rad
        if (dimensions[next] || std::abs(network.TurnAt(end, stroke, next)) > kStraight) break;
        dimensions[next] = true;
        stroke = next;
        end = network.OtherEnd(next, end);
      }
    }
  }
  return dimensions;
}

}  // namespace enfilade::perception
