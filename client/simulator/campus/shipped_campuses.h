// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/simulator/campus/campus.h"

namespace enfilade::simulator {

// The campuses that are built into the program, by name: "figure1", "lookalike", "rooms", ... NOT_FOUND names them all.
absl::StatusOr<Campus> ShippedCampus(const std::string& name);
std::vector<std::string> ShippedCampusNames();

}  // namespace enfilade::simulator
