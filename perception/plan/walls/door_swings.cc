// SPDX-License-Identifier: Apache-2.0
#include "perception/plan/walls/door_swings.h"

#include <algorithm>
#include <cmath>

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

}  // namespace

std::vector<bool> FindSwings(const StrokeGraph& drawing, const std::vector<bool>& among, double diagonal) {
  constexpr double kLargestRadius = 0.03, kLargestColumn = 0.012;  // of the diagonal
  constexpr double kMostOfALeaf = 4;                               // rad; what turns farther is a circle
  constexpr double kLeastTurn = 0.8;                               // rad
  constexpr std::size_t kFewestPieces = 4;
  const Network network(drawing, among);
  std::vector<bool> swings(among.size(), false);
  for (std::size_t i = 0; i < among.size(); ++i) {
    if (!among[i]) continue;
    for (const int begin : {drawing.strokes[i].from, drawing.strokes[i].to}) {
      const Arc arc = FollowArc(network, static_cast<int>(i), begin);
      if (arc.strokes.size() < kFewestPieces || std::abs(arc.turn) < kLeastTurn) continue;
      const double largest = std::abs(arc.turn) < kMostOfALeaf ? kLargestRadius : kLargestColumn;
      if (arc.radius > largest * diagonal) continue;
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

}  // namespace enfilade::perception
