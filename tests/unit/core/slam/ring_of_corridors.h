// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "tests/unit/core/slam/synthetic_drive.h"

namespace enfilade::testing {

inline constexpr SyntheticOdometry kPoorOdometry{0.05, 0.06};

// Corridors around a block, with niches that tell one place from another. 30 m x 18 m.
inline std::vector<Wall> RingOfCorridors() {
  return WallsFromText({"##############################",  //
                        "#    #       ##       #      #",  //
                        "#                            #",  //
                        "#   ###################      #",  //
                        "#   #                 #     ##",  //
                        "##  #                 ##     #",  //
                        "#   #                 #      #",  //
                        "#   ##                #      #",  //
                        "#   #                 #   ####",  //
                        "#   #                 #      #",  //
                        "##  #                 #      #",  //
                        "##  #                 #      #",  //
                        "#   #                 ##     #",  //
                        "#   ###################      #",  //
                        "#                         #  #",  //
                        "#                            #",  //
                        "#    #      ##      #        #",  //
                        "##############################"},
                       1.0);
}

// From corner to corner.
inline std::vector<Pose2> TwoRounds() {
  return Drive({{2.5, 2.5}, {24.5, 2.5}, {24.5, 15.5}, {2.5, 15.5}, {2.5, 2.5}, {24.5, 2.5}, {24.5, 15.5}}, 0.25);
}

}  // namespace enfilade::testing
