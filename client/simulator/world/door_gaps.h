// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "client/simulator/campus/campus.h"

namespace enfilade::simulator {

struct DoorGap {
  double begin = 0.0;  // m, along the wall
  double end = 0.0;
  const Door* door = nullptr;
};

// The gaps that the level's doors cut into the wall from `from` to `to`.
std::vector<DoorGap> DoorGapsOf(const Campus& campus, const std::string& level, const Eigen::Vector2d& from,
                                const Eigen::Vector2d& to);

}  // namespace enfilade::simulator
