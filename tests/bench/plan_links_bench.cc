// SPDX-License-Identifier: Apache-2.0
// How many wrong sightings of a plan's walls the joint graph stands.
//   bench_plan_links [SEEDS]
// Eight rooms in a row, a map in each, doors between them (0.03 m and 1 degree), and a plan whose corners are off by
// 0.1 m. Each room has seen its four walls. Then wrong sightings are added, until they are a share of all: of all
// rooms, each aside by 0.3 to 2 m on its own ("random"); or of one room, all aside by the same metre, as if it had been
// taken for a room that is not there ("consistent"; the share is that of the room). Prints JSON: for each share the
// error of the rooms that are concerned, m, the median and the 95th percentile of all seeds, beside the error without a
// plan; the share of seeds in which the plan is refused; and of those in which it is not, the share of wrong sightings
// in use, and of right ones that are not.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

#include "core/graph/graph_optimization.h"
#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "tests/unit/core/graph/plans/row_of_rooms.h"

namespace enfilade::bench {
namespace {

using Row = testing::RowOfRooms;

constexpr int kRooms = 8;
constexpr int kShifted = 4;  // the room of consistent ones
constexpr double kCornerSigma = 0.1;

enum class Wrong { kRandom, kConsistent };

// The struts of a room's walls.
std::vector<int> WallsOf(const Row& row, int room) { return {room, room + 1, row.Below(room), row.Below(room) + 1}; }

// Adds a sighting that is aside in the world by `aside`, m, or rather by what of that is across the wall.
void SeeAside(Row& row, int room, int strut, const Eigen::Vector2d& aside) {
  row.See(room, strut);
  Pose2& line = row.ties().sightings.back().T_map_line;
  const Pose2 T_world_line = row.world().T_world_maps[static_cast<std::size_t>(room)] * line;
  const Eigen::Vector2d across(-std::sin(T_world_line.yaw), std::cos(T_world_line.yaw));
  line = line * Pose2{0.0, aside.dot(across), 0.0};
}

// As many that `share` of all sightings of the room are wrong.
int WrongIn(double share, int right) { return static_cast<int>(std::lround(share / (1.0 - share) * right)); }

void AddWrong(Row& row, Wrong kind, double share, unsigned seed) {
  std::mt19937_64 random(1000 + seed);
  const double heading = testing::Uniform(0.0, 2 * M_PI, random);
  for (int room = 0; room < kRooms; ++room) {
    if (kind == Wrong::kConsistent && room != kShifted) continue;
    const std::vector<int> walls = WallsOf(row, room);
    const int wrong = WrongIn(share, static_cast<int>(walls.size()));
    for (int i = 0; i < wrong; ++i) {
      const double far = kind == Wrong::kRandom ? testing::Uniform(0.3, 2.0, random) : 1.0;
      const double angle = kind == Wrong::kRandom ? testing::Uniform(0.0, 2 * M_PI, random) : heading;
      SeeAside(row, room, walls[static_cast<std::size_t>(i) % walls.size()],
               far * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    }
  }
}

struct Trial {
  double error = 0.0;    // m
  double without = 0.0;  // m
  bool refused = false;
  double wrong_in_use = 0.0;
  double right_left_out = 0.0;
};

Trial Try(Wrong kind, double share, unsigned seed) {
  Row row(kRooms, kCornerSigma, seed);
  std::vector<graph::LinkPoint> doors;
  for (int i = 0; i + 1 < kRooms; ++i) doors.push_back(row.Door(i, 0.03, 1.0 * kDegree));
  for (int i = 0; i < kRooms; ++i) row.SeeAll(i);
  const std::size_t right = row.ties().sightings.size();
  AddWrong(row, kind, share, seed);
  const graph::SolvedGraph with = graph::OptimizeGraph(row.WithPlan(doors)).value();
  const graph::SolvedGraph without = graph::OptimizeGraph(row.WithoutPlan(doors)).value();
  Trial trial;
  int rooms = 0;
  for (int room = 1; room < kRooms; ++room) {
    if (kind == Wrong::kConsistent && room != kShifted) continue;
    ++rooms;
    trial.error += row.ErrorOf(with, room);
    trial.without += row.ErrorOf(without, room);
  }
  trial.error /= rooms;
  trial.without /= rooms;
  const graph::PlanUse& use = with.plans.at(0);
  trial.refused = !use.contradiction.empty();
  int wrong_used = 0;
  int right_off = 0;
  for (std::size_t i = 0; i < use.sightings.size(); ++i) {
    if (i >= right && use.sightings[i].used) ++wrong_used;
    if (i < right && !use.sightings[i].used) ++right_off;
  }
  trial.wrong_in_use =
      static_cast<double>(wrong_used) / static_cast<double>(std::max<std::size_t>(1, use.sightings.size() - right));
  trial.right_left_out = static_cast<double>(right_off) / static_cast<double>(right);
  return trial;
}

double Quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values.at(static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5));
}

nlohmann::json CurveOf(Wrong kind, unsigned seeds) {
  nlohmann::json curve = nlohmann::json::array();
  for (int percent = 0; percent <= 95; percent += 5) {
    std::vector<double> errors;
    std::vector<double> without;
    double refused = 0;
    double wrong_in_use = 0;
    double right_left_out = 0;
    for (unsigned seed = 1; seed <= seeds; ++seed) {
      const Trial trial = Try(kind, percent / 100.0, seed);
      errors.push_back(trial.error);
      without.push_back(trial.without);
      if (trial.refused) {
        ++refused;
        continue;
      }
      wrong_in_use += trial.wrong_in_use;
      right_left_out += trial.right_left_out;
    }
    const double kept = std::max(1.0, seeds - refused);
    curve.push_back({{"wrong", percent / 100.0},
                     {"error_m", Quantile(errors, 0.5)},
                     {"error_p95_m", Quantile(errors, 0.95)},
                     {"without_m", Quantile(without, 0.5)},
                     {"refused", refused / seeds},
                     {"wrong_in_use", wrong_in_use / kept},
                     {"right_left_out", right_left_out / kept}});
    std::cerr << (kind == Wrong::kRandom ? "random " : "consistent ") << curve.back().dump() << "\n";
  }
  return curve;
}

}  // namespace
}  // namespace enfilade::bench

int main(int argc, char** argv) {
  const unsigned seeds = argc > 1 ? static_cast<unsigned>(std::atoi(argv[1])) : 20;
  using enfilade::bench::Wrong;
  std::cout << nlohmann::json{{"random", enfilade::bench::CurveOf(Wrong::kRandom, seeds)},
                              {"consistent", enfilade::bench::CurveOf(Wrong::kConsistent, seeds)}}
                   .dump(1)
            << "\n";
  return 0;
}
