// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "client/cli/command.h"
#include "enfilade/v1/map_area.pb.h"
#include "nlohmann/json.hpp"

namespace enfilade::cli {

nlohmann::json MapAreaToJson(const v1::MapArea& area);
// A row of a table with MapAreaHeader.
std::vector<std::string> MapAreaRow(const v1::MapArea& area);
const std::vector<std::string>& MapAreaHeader();

// "keep-out"
std::string KindText(v1::MapArea::Kind kind);
// "from 2026-01-01 08:00:00 until 2026-02-01 00:00:00 UTC"; "always".
std::string ValidityText(const v1::MapArea& area);

// The area as JSON, or one line: `what`, its display name and its resource name.
void PrintMapArea(const Globals& globals, const std::string& what, const v1::MapArea& area);

}  // namespace enfilade::cli
