// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace enfilade::perception {

// The skeleton of a drawing as a graph, in pixels. Its joints are ends, branchings, and bends of lines.

// The sums that a line is fitted to. They add up: the line through several strokes needs no points.
struct Moments {
  double count = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();

  void Add(const Eigen::Vector2d& p) {
    count += 1;
    sum += p;
    squares += p * p.transpose();
  }
  void Add(const Moments& other) {
    count += other.count;
    sum += other.sum;
    squares += other.squares;
  }
};

// p with normal . p = offset, by total least squares.
struct FittedLine {
  Eigen::Vector2d normal = Eigen::Vector2d::UnitX();
  double offset = 0;
  double rms = 0;  // of the points' distances, px

  double DistanceTo(const Eigen::Vector2d& p) const { return normal.dot(p) - offset; }
  Eigen::Vector2d Direction() const { return {-normal.y(), normal.x()}; }
};

FittedLine FitLine(const Moments& moments);

// A straight piece of the drawing between two joints.
struct Stroke {
  int from = 0;
  int to = 0;
  double width = 0;   // px, the median along it; 0: the edge of a mass
  Moments moments{};  // of its middle part, away from the joints
};

struct StrokeGraph {
  std::vector<Eigen::Vector2d> joints;
  std::vector<Stroke> strokes;

  double LengthOf(const Stroke& stroke) const { return (joints[stroke.to] - joints[stroke.from]).norm(); }
};

}  // namespace enfilade::perception
