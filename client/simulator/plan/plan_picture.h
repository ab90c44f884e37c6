// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include "absl/status/statusor.h"
#include "client/simulator/simulation.h"
#include "client/simulator/world/world.h"

namespace enfilade::simulator {

// A plan of one level as a PNG: areas, walls, glass, doors, boxes, people's paths, and the robots' drives with their
// passages.
absl::StatusOr<std::string> DrawPlan(const World& world, const std::string& level,
                                     const std::map<std::string, GroundTruth>& drives);

}  // namespace enfilade::simulator
