// SPDX-License-Identifier: Apache-2.0
#include "core/doors/jamb_walls.h"

#include <algorithm>
#include <cmath>

namespace enfilade::doors {
namespace {

constexpr double kTurnStep = 3.0 * M_PI / 180.0;
constexpr double kThickest = 0.3;     // m, of a wall
constexpr double kOffset = 0.15;      // m, of the line from the posts' middle
constexpr double kInterrupted = 0.2;  // m without a hit that do not end a surface
constexpr double kPane = 1.3;         // m: the longest interruption behind which the wall continues
constexpr double kCorner = 0.6;       // m: the least length of the wall that it meets, before and behind
constexpr double kAgain = 0.2;        // m: the least length of wall behind an interruption

struct Run {
  double wall = 0.0;   // m beyond the post
  double again = 0.0;  // m behind the interruption
  double end = 0.0;    // m beyond the post
};

// Along `outward` (unit) from `post`; `missing` m without a hit do not end the wall.
Run RunFrom(const LocalMap& map, const Eigen::Vector2d& post, const Eigen::Vector2d& outward, double limit,
            double missing) {
  const Eigen::Vector2d aside = map.cell() * Eigen::Vector2d(-outward.y(), outward.x());
  const auto occupied = [&](double s) {
    const Eigen::Vector2d at = post + s * outward;
    for (const int off : {0, -1, 1}) {
      const Eigen::Vector2d p = at + off * aside;
      if (map.IsOccupied(map.CellOf(p.x()), map.CellOf(p.y()))) return true;
    }
    return false;
  };
  Run run;
  double s = 0.0;
  for (; s <= limit && s - run.wall <= missing; s += map.cell()) {
    if (occupied(s)) run.wall = s;
  }
  run.end = run.wall;
  double begin = -1.0;
  double last = 0.0;
  for (; s <= limit && (begin >= 0.0 || s - run.wall <= kPane); s += map.cell()) {
    if (occupied(s)) {
      if (begin < 0.0) begin = s;
      last = s;
    } else if (begin >= 0.0 && s - last > missing) {
      if (last - begin >= kAgain) break;
      begin = -1.0;
    }
  }
  if (begin >= 0.0 && last - begin >= kAgain) {
    run.again = last - begin;
    run.end = last;
  }
  return run;
}

// How far surfaces continue from `from` along `on`, up to `limit`, including cells beside the line.
double SurfaceAlong(const LocalMap& map, const Eigen::Vector2d& from, const Eigen::Vector2d& on, double limit) {
  const Eigen::Vector2d aside = map.cell() * Eigen::Vector2d(-on.y(), on.x());
  double last = 0.0;
  for (double s = map.cell(); s <= limit && s - last <= kInterrupted; s += map.cell()) {
    for (const int off : {0, -1, 1}) {
      const Eigen::Vector2d at = from + s * on + off * aside;
      if (map.IsOccupied(map.CellOf(at.x()), map.CellOf(at.y()))) last = s;
    }
  }
  return last;
}

// Whether a wall crosses the line near `wall` metres along `outward` from `post`, at 80 to 100 degrees.
bool MeetsWall(const LocalMap& map, const Eigen::Vector2d& post, const Eigen::Vector2d& outward, double wall) {
  const double across = std::atan2(outward.y(), outward.x()) + M_PI / 2.0;
  for (double s = std::max(0.0, wall - kThickest); s <= wall + 2.0 * map.cell(); s += map.cell()) {
    const Eigen::Vector2d at = post + s * outward;
    for (const double turn : {-0.17, -0.085, 0.0, 0.085, 0.17}) {
      const Eigen::Vector2d on(std::cos(across + turn), std::sin(across + turn));
      if (std::min(SurfaceAlong(map, at, on, kCorner), SurfaceAlong(map, at, -on, kCorner)) > kCorner - 0.1)
        return true;
    }
  }
  return false;
}

}  // namespace

JambWalls FindJambWalls(const LocalMap& map, const Eigen::Vector2d& left, const Eigen::Vector2d& right, double limit,
                        double missing) {
  const Eigen::Vector2d edge = left - right;
  const double width = std::max(edge.norm(), map.cell());
  const Eigen::Vector2d middle = (left + right) / 2.0;
  const int turns = static_cast<int>(std::ceil(std::atan2(kThickest, width) / kTurnStep));
  const int offsets = static_cast<int>(std::round(kOffset / map.cell()));
  JambWalls best;
  double best_score = -1.0;
  for (int turn = -turns; turn <= turns; ++turn) {
    const double angle = std::atan2(edge.y(), edge.x()) + turn * kTurnStep;
    const Eigen::Vector2d outward(std::cos(angle), std::sin(angle));
    const Eigen::Vector2d aside(-outward.y(), outward.x());
    for (int offset = -offsets; offset <= offsets; ++offset) {
      const Eigen::Vector2d origin = middle + offset * map.cell() * aside;
      const Eigen::Vector2d left_post = origin + width / 2.0 * outward;
      const Eigen::Vector2d right_post = origin - width / 2.0 * outward;
      const Run on_left = RunFrom(map, left_post, outward, limit, missing);
      const Run on_right = RunFrom(map, right_post, -outward, limit, missing);
      // Of equally good lines, the one nearest to the posts.
      const double score = on_left.wall + on_right.wall + 0.5 * (on_left.again + on_right.again) -
                           0.01 * (std::abs(turn) + std::abs(offset));
      if (score <= best_score) continue;
      best_score = score;
      best = {on_left.wall,
              on_right.wall,
              on_left.again,
              on_right.again,
              false,
              false,
              left_post + on_left.end * outward,
              right_post - on_right.end * outward};
    }
  }
  best.left_cornered = MeetsWall(map, left, edge / width, best.left);
  best.right_cornered = MeetsWall(map, right, -edge / width, best.right);
  return best;
}

double ParallelSurfaces(const LocalMap& map, const Eigen::Vector2d& left, const Eigen::Vector2d& right, double limit) {
  constexpr double kStep = 5.0 * M_PI / 180.0;
  constexpr double kMissing = 0.15;  // m without a hit that do not end a surface
  const Eigen::Vector2d edge = (left - right).normalized();
  // The longest from a post, whose place is uncertain by one or two cells.
  const auto run_from = [&](const Eigen::Vector2d& post, const Eigen::Vector2d& outward, const Eigen::Vector2d& on) {
    double longest = 0.0;
    for (int begin = -1; begin <= 2; ++begin) {
      const Eigen::Vector2d from = post + begin * map.cell() * outward;
      for (const double sense : {-1.0, 1.0}) {
        double last = 0.0;
        for (double s = 0.0; s <= limit && s - last <= kMissing; s += map.cell()) {
          const Eigen::Vector2d at = from + sense * s * on;
          if (map.IsOccupied(map.CellOf(at.x()), map.CellOf(at.y()))) last = s;
        }
        longest = std::max(longest, last);
      }
    }
    return longest;
  };
  double longest = 0.0;
  for (int k = 8; k <= 28; ++k) {
    const double turn = k * kStep;
    const Eigen::Vector2d on(std::cos(turn) * edge.x() - std::sin(turn) * edge.y(),
                             std::sin(turn) * edge.x() + std::cos(turn) * edge.y());
    longest = std::max(longest, std::min(run_from(left, edge, on), run_from(right, -edge, on)));
  }
  return longest;
}

}  // namespace enfilade::doors
