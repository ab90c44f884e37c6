// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace enfilade {

// Whether a map lies indoors or outdoors. Selects the map's SLAM configuration: short range indoors, long range
// outdoors.
enum class Environment : std::uint8_t { kIndoor = 1, kOutdoor = 2 };

inline std::string ToString(Environment environment) {
  return environment == Environment::kIndoor ? "indoor" : "outdoor";
}

}  // namespace enfilade
