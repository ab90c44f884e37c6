// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "nlohmann/json.hpp"

namespace enfilade::robot {

// Something that happened, for people and for programs.
struct Notification {
  std::string event;      // "state", "session", "report", "map", "verdict", ... (docs/robot.md)
  std::string text;       // one line for people; empty: for programs only
  nlohmann::json fields;  // an object
};

// The JSON form of a pose, m and rad.
inline nlohmann::json PoseToJson(double x, double y, double yaw) { return {{"x_m", x}, {"y_m", y}, {"yaw_rad", yaw}}; }

// Called from several threads.
using NotificationListener = std::function<void(const Notification&)>;

}  // namespace enfilade::robot
