// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "client/simulator/campus.h"
#include "client/simulator/world.h"

namespace enfilade::simulator {

// The upright surfaces of one level: the walls with the doors cut out of them, lintels, doors, boxes.
std::vector<Face> FacesOf(const Campus& campus, const std::string& level);

// The paint of one surface (floors and ceilings by `salt`).
Paint PaintOf(const Campus& campus, const std::string& texture, std::uint64_t salt);

}  // namespace enfilade::simulator
