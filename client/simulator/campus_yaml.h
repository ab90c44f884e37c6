// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "client/simulator/campus.h"

namespace enfilade::simulator {

// A campus from its text (docs/simulator.md). INVALID_ARGUMENT with the line: no YAML, a key that is not known, a value
// of another type, and what Validate refuses.
absl::StatusOr<Campus> ParseCampus(std::string_view yaml);

// The campuses that come with the program, by name: "figure1", "lookalike", "rooms", ... NOT_FOUND names them all.
absl::StatusOr<Campus> ShippedCampus(const std::string& name);
std::vector<std::string> ShippedCampusNames();

// The walls of a drawing: '#' is a cell of wall, a letter a point by that name on free ground, anything else free
// ground; the first row is the northernmost. `origin` is the lower left corner.
struct Drawing {
  std::vector<Wall> walls;  // sheets round the walled cells
  std::map<std::string, Eigen::Vector2d> points;
};
absl::StatusOr<Drawing> ParseDrawing(std::string_view rows, double cell, const Eigen::Vector2d& origin);

}  // namespace enfilade::simulator
