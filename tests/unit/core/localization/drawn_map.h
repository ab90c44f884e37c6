// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/grid/occupancy_grid.h"
#include "core/localization/localize.h"
#include "core/localization/searchable_map.h"
#include "core/sensor/laser_scan.h"

namespace enfilade::localization {

inline absl::Status GoOn() { return absl::OkStatus(); }

// Rooms drawn as text, a character for 0.25 m x 0.25 m: '#' wall, ' ' free, '?' free, but unknown to the map. The
// origin is the lower left corner.
class DrawnMap {
 public:
  static constexpr double kCharacter = 0.25;
  static constexpr double kCell = 0.05;

  explicit DrawnMap(std::vector<std::string> rows) : rows_(std::move(rows)) {}

  grid::OccupancyGrid Grid() const {
    constexpr int kCells = 5;  // per character
    grid::OccupancyGrid grid;
    grid.geometry.resolution = kCell;
    grid.geometry.width = static_cast<int>(rows_.front().size()) * kCells;
    grid.geometry.height = static_cast<int>(rows_.size()) * kCells;
    for (int row = 0; row < grid.geometry.height; ++row) {
      for (int column = 0; column < grid.geometry.width; ++column) {
        const char drawn = At((column + 0.5) * kCell, (row + 0.5) * kCell);
        grid.cells.push_back(drawn == '?'   ? grid::kUnknownCell
                             : drawn == '#' ? grid::CellFromProbability(0.95)
                                            : grid::CellFromProbability(0.1));
      }
    }
    return grid;
  }

  std::shared_ptr<const SearchableMap> Searchable() const {
    return std::make_shared<const SearchableMap>(Grid(), LocalizationOptions());
  }

  // As a candidate for Localize.
  CandidateMap Candidate() const {
    return {[map = Searchable()] { return map; }};
  }

  // The character at a point, m; wall outside.
  char At(double x, double y) const {
    const int column = static_cast<int>(std::floor(x / kCharacter));
    const int row = static_cast<int>(rows_.size()) - 1 - static_cast<int>(std::floor(y / kCharacter));
    if (row < 0 || row >= static_cast<int>(rows_.size()) || column < 0 ||
        column >= static_cast<int>(rows_.front().size())) {
      return '#';
    }
    return rows_[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)];
  }

  // What a scanner at the robot's origin measures, without noise.
  sensor::LaserScan Scan(const Pose2& T_map_robot, double field_of_view = 2.0 * M_PI, float range_max = 20.0F) const {
    constexpr int kBeams = 360;
    constexpr double kStep = 0.005;  // m
    sensor::LaserScan scan;
    scan.angle_increment = field_of_view / kBeams;
    scan.angle_min = -field_of_view / 2.0;
    scan.range_min = 0.05F;
    scan.range_max = range_max;
    for (int i = 0; i < kBeams; ++i) {
      const double angle = T_map_robot.yaw + scan.angle(static_cast<std::size_t>(i));
      double range = 0.0;
      while (range < range_max &&
             At(T_map_robot.x + range * std::cos(angle), T_map_robot.y + range * std::sin(angle)) != '#') {
        range += kStep;
      }
      scan.ranges.push_back(range < range_max ? static_cast<float>(range) : std::numeric_limits<float>::infinity());
    }
    return scan;
  }

 private:
  std::vector<std::string> rows_;
};

// 10 m x 5 m, with nothing twice.
inline DrawnMap UniqueRoom() {
  return DrawnMap({"########################################",  //
                   "#                   #                  #",  //
                   "#                   #                  #",  //
                   "#    ###            #                  #",  //
                   "#    ###            #        ##        #",  //
                   "#                   #        ##        #",  //
                   "#                   #                  #",  //
                   "#                                      #",  //
                   "#                                      #",  //
                   "#                                 ######",  //
                   "#            ##                   #    #",  //
                   "#            ##                   #    #",  //
                   "#                   #             #    #",  //
                   "######              #             ######",  //
                   "#    #              #                  #",  //
                   "#    #              #                  #",  //
                   "######              #   ####           #",  //
                   "#                   #   ####           #",  //
                   "#                   #                  #",  //
                   "########################################"});
}

// A room that looks the same turned by half a turn.
inline DrawnMap SymmetricRoom() {
  return DrawnMap({"########################",  //
                   "#                      #",  //
                   "#                      #",  //
                   "#   ##                 #",  //
                   "#   ##                 #",  //
                   "#                      #",  //
                   "#                      #",  //
                   "#                      #",  //
                   "#                      #",  //
                   "#                 ##   #",  //
                   "#                 ##   #",  //
                   "#                      #",  //
                   "#                      #",  //
                   "########################"});
}

// Two rooms that are alike, on a corridor that is not alike before them.
inline DrawnMap TwoRoomsAlike() {
  return DrawnMap({"#########################################",  //
                   "#                   #                   #",  //
                   "#  ###              #  ###              #",  //
                   "#  ###              #  ###              #",  //
                   "#                   #                   #",  //
                   "#                   #                   #",  //
                   "#                   #                   #",  //
                   "#             ##    #             ##    #",  //
                   "#             ##    #             ##    #",  //
                   "#                   #                   #",  //
                   "#                   #                   #",  //
                   "#######     ###############     #########",  //
                   "#                                       #",  //
                   "#                                       #",  //
                   "#                                       #",  //
                   "#                                ####   #",  //
                   "#   #                            ####   #",  //
                   "#########################################"});
}

}  // namespace enfilade::localization
