// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/geometry/pose2.h"
#include "nlohmann/json.hpp"

namespace enfilade::testing {

// The lines of a program's output that are JSON objects.
inline std::vector<nlohmann::json> ReadJsonLines(const std::filesystem::path& file) {
  std::vector<nlohmann::json> lines;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    nlohmann::json object = nlohmann::json::parse(line, nullptr, false);
    if (object.is_object()) lines.push_back(std::move(object));
  }
  return lines;
}

inline Pose2 PoseOf(const nlohmann::json& pose) { return {pose.at("x_m"), pose.at("y_m"), pose.at("yaw_rad")}; }

}  // namespace enfilade::testing
