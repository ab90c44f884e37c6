#include "client/simulator/floor_plan.h"

#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "core/base/error.h"

namespace enfilade::simulator {
namespace {

constexpr double kEnfiladeCell = 0.25;  // m
constexpr std::string_view kEnfilade = R"(
############################################################################
######                  #                   ###   #                        #
######                  #                   ###   #                        #
######                  #                   ###   #                        #
#                       #                   ###   #                        #
#                       #                   ###   #                   ######
#                       #                   ###   #                   ######
#                       #                         #                   ######
#                       #            e            #                   ######
#                       #                         #                        #
#                                                                          #
#         c                    d             f             g               #
#                                                                          #
#                                     ##                                   #
#                       #             ##          #                        #
#                       #                         #                        #
#                       #                         #                        #
#                       #                         #             h          #
#                       #                         #                        #
#                       #                         #                        #
#                       #     #######             #     ##                 #
#                       #     #######             #     ##                 #
#               ######  #     #######             #                        #
#               ######  #                         #                        #
#               ######  #                         #                 ##     #
#         b     ######  #                         #                 ##     #
#               ######  #                         #                        #
#                       #                         #                        #
#                       #                         #                        #
#########    ##################################################    #########
#                             ####                                         #
#                             ####                                         #
#                                                                          #
#                                                                          #
#                                                                          #
#           a                           j                       i          #
#                                                                          #
#                                                                          #
#                                                                          #
#                                             ##                           #
#                   #######                   ##                           #
############################################################################
)";

}  // namespace

absl::StatusOr<FloorPlan> FloorPlan::Parse(std::string_view drawing, double cell_size) {
  if (!(cell_size > 0.0) || !std::isfinite(cell_size))
    return InvalidArgument("cell size {} m is not positive", cell_size);
  std::vector<std::string> rows;
  while (!drawing.empty()) {
    const std::size_t end = drawing.find('\n');
    const std::string_view row = drawing.substr(0, end);
    if (!row.empty()) rows.emplace_back(row);
    drawing = end == std::string_view::npos ? std::string_view() : drawing.substr(end + 1);
  }
  if (rows.empty()) return InvalidArgument("the floor plan has no rows");
  std::map<char, Eigen::Vector2d> points;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t column = 0; column < rows[i].size(); ++column) {
      const char c = rows[i][column];
      if (c < 'a' || c > 'z') continue;
      const Eigen::Vector2d middle((static_cast<double>(column) + 0.5) * cell_size,
                                   (static_cast<double>(rows.size() - i) - 0.5) * cell_size);
      if (!points.emplace(c, middle).second) return InvalidArgument("the floor plan has two points '{}'", c);
    }
  }
  if (points.size() < 2)
    return InvalidArgument("the floor plan's route has {} points: expected two or more", points.size());
  FloorPlan plan(std::move(rows), cell_size);
  for (const auto& [letter, point] : points) plan.route_.push_back(point);
  return plan;
}

bool FloorPlan::IsWall(int column, int row) const {
  if (row < 0 || column < 0 || row >= static_cast<int>(rows_.size())) return true;
  const std::string& cells = rows_[rows_.size() - 1 - static_cast<std::size_t>(row)];
  return static_cast<std::size_t>(column) >= cells.size() || cells[static_cast<std::size_t>(column)] == '#';
}

bool FloorPlan::IsWallAt(const Eigen::Vector2d& point) const {
  return IsWall(static_cast<int>(std::floor(point.x() / cell_size_)),
                static_cast<int>(std::floor(point.y() / cell_size_)));
}

double FloorPlan::DistanceToWall(const Eigen::Vector2d& from, const Eigen::Vector2d& direction, double limit) const {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  int cell[2];
  int step[2];
  double next[2];   // distance at which the ray enters the next column, row
  double every[2];  // distance from one column, row to the next
  for (int axis = 0; axis < 2; ++axis) {
    const double position = from[axis] / cell_size_;
    cell[axis] = static_cast<int>(std::floor(position));
    step[axis] = direction[axis] > 0.0 ? 1 : -1;
    every[axis] = direction[axis] == 0.0 ? kNever : cell_size_ / std::abs(direction[axis]);
    const double to_border = step[axis] > 0 ? cell[axis] + 1 - position : position - cell[axis];
    next[axis] = direction[axis] == 0.0 ? kNever : to_border * every[axis];
  }
  double distance = 0.0;
  while (!IsWall(cell[0], cell[1])) {
    const int axis = next[0] < next[1] ? 0 : 1;
    distance = next[axis];
    if (distance >= limit) return limit;
    cell[axis] += step[axis];
    next[axis] += every[axis];
  }
  return distance;
}

const FloorPlan& EnfiladePlan() {
  static const FloorPlan* const plan = new FloorPlan(*FloorPlan::Parse(kEnfilade, kEnfiladeCell));
  return *plan;
}

}  // namespace enfilade::simulator
