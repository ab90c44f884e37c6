// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "enfilade/v1/link_point.pb.h"
#include "nlohmann/json.hpp"

namespace enfilade::cli {

nlohmann::json LinkPointToJson(const v1::LinkPoint& link_point);
// A line of a table under kLinkPointHeader.
std::vector<std::string> ToRow(const v1::LinkPoint& link_point);
const std::vector<std::string>& LinkPointHeader();

}  // namespace enfilade::cli
