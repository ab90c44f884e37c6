// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "enfilade/v1/link_point.pb.h"
#include "nlohmann/json.hpp"

namespace enfilade::cli {

nlohmann::json LinkPointToJson(const v1::LinkPoint& link_point);
// A row of a table with LinkPointHeader.
std::vector<std::string> LinkPointRow(const v1::LinkPoint& link_point);
const std::vector<std::string>& LinkPointHeader();

}  // namespace enfilade::cli
