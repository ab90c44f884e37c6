// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "client/simulator/campus/campus.h"
#include "core/options/strict_mapping.h"

// The shapes of a campus file. Errors go to the mapping's status. Include it in source files only.
namespace enfilade::simulator {

Eigen::Vector2d Point(yaml_options::StrictMapping& map, const std::string& key);
std::vector<Eigen::Vector2d> Points(yaml_options::StrictMapping& map, const std::string& key);

// `polygon`, or `rect` (x, y, width, height) turned by `yaw_deg`.
std::vector<Eigen::Vector2d> Outline(yaml_options::StrictMapping& map);

// Places the door's jambs in the `side` of a rectangular area (south if not given), `width` m apart, with their middle
// `at` m from the side's western or southern end (its middle if not given).
void PlaceDoor(yaml_options::StrictMapping& map, const Area& area, Door& door);

}  // namespace enfilade::simulator
