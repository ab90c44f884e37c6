// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "client/simulator/campus/campus.h"
#include "client/simulator/world/world.h"

namespace enfilade::simulator {

// The vertical surfaces of one level: walls with the doors cut out of them, lintels, doors, boxes.
std::vector<Face> BuildFaces(const Campus& campus, const std::string& level);

// The paint of one surface. `salt` tells surfaces of one texture apart.
Paint PaintOf(const Campus& campus, const std::string& texture, std::uint64_t salt);

}  // namespace enfilade::simulator
