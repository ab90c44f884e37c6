// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "client/cli/command.h"
#include "enfilade/v1/prior_map.pb.h"
#include "nlohmann/json.hpp"

namespace enfilade::cli {

nlohmann::json PriorMapToJson(const v1::PriorMap& prior_map);
// A row of a table with PriorMapHeader.
std::vector<std::string> PriorMapRow(const v1::PriorMap& prior_map);
const std::vector<std::string>& PriorMapHeader();

std::string StateText(v1::PriorMap::State state);                // "proposed"
std::string ElementsText(const v1::PriorMapElements& elements);  // "120 walls, 64 corners, ..."
std::string AlignmentText(const v1::PriorAlignment& alignment);  // "rigid, 0.02 m per unit of the plan; 93 % ..."

// The prior map as JSON, or one line: `what`, its display name and its resource name.
void PrintPriorMap(const Globals& globals, const std::string& what, const v1::PriorMap& prior_map);

}  // namespace enfilade::cli
