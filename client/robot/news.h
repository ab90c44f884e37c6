// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "nlohmann/json.hpp"

namespace enfilade::robot {

// Something that happened, for people and for programs.
struct News {
  std::string event;      // "state", "session", "door", "map", "verdict", ... (docs/robot.md)
  std::string text;       // one line for people; empty: for programs only
  nlohmann::json fields;  // an object
};

// Called from several threads.
using NewsListener = std::function<void(const News&)>;

}  // namespace enfilade::robot
