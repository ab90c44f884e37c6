// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/prior/prior_map_output.h"

#include <cmath>
#include <iostream>
#include <utility>

#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "fmt/format.h"

namespace enfilade::cli {
namespace {

nlohmann::json AlignmentToJson(const v1::PriorAlignment& alignment) {
  nlohmann::json document = {
      {"affine_world_sheet",
       std::vector<double>(alignment.affine_world_sheet().begin(), alignment.affine_world_sheet().end())},
      {"model", EnumText(v1::PriorAlignment::Model_Name(alignment.model()), "MODEL_")},
      {"mirrored", alignment.mirrored()},
      {"explained", alignment.explained()},
      {"contradicted", alignment.contradicted()},
      {"rival_ratio", alignment.rival_ratio()},
      {"maps", std::vector<std::string>(alignment.maps().begin(), alignment.maps().end())},
      {"graph_version", alignment.graph_version()},
      {"tied_walls", alignment.tied_walls()},
      {"joined_maps", std::vector<std::string>(alignment.joined_maps().begin(), alignment.joined_maps().end())},
      {"pairs", nlohmann::json::array()},
      {"align_time", FormatTime(alignment.align_time())}};
  for (const v1::ControlPair& pair : alignment.pairs()) {
    document["pairs"].push_back(
        {{"sheet", {pair.sheet_x(), pair.sheet_y()}}, {"map", pair.map()}, {"point_m", {pair.x_m(), pair.y_m()}}});
  }
  return document;
}

// m per unit of the sheet: the mean of both axes (geometric).
double ScaleOf(const v1::PriorAlignment& alignment) {
  if (alignment.affine_world_sheet_size() != 6) return 0;
  const auto& a = alignment.affine_world_sheet();
  return std::sqrt(std::abs(a[0] * a[4] - a[1] * a[3]));
}

}  // namespace

nlohmann::json PriorMapToJson(const v1::PriorMap& prior_map) {
  const v1::PriorMapElements& elements = prior_map.elements();
  nlohmann::json document = {
      {"name", prior_map.name()},
      {"display_name", prior_map.display_name()},
      {"level", prior_map.level()},
      {"state", StateText(prior_map.state())},
      {"reason", prior_map.reason()},
      {"file_name", prior_map.file_name()},
      {"walls", elements.walls()},
      {"corners", elements.corners()},
      {"doors", elements.doors()},
      {"rooms", elements.rooms()},
      {"shafts", elements.shafts()},
      {"warnings", std::vector<std::string>(prior_map.warnings().begin(), prior_map.warnings().end())},
      {"etag", prior_map.etag()},
      {"create_time", FormatTime(prior_map.create_time())},
      {"update_time", FormatTime(prior_map.update_time())}};
  if (elements.metres_per_unit() > 0) document["metres_per_unit"] = elements.metres_per_unit();
  if (prior_map.has_alignment()) document["alignment"] = AlignmentToJson(prior_map.alignment());
  return document;
}

const std::vector<std::string>& PriorMapHeader() {
  static const std::vector<std::string> header = {"PLAN", "NAME", "LEVEL", "STATE", "WALLS", "REASON"};
  return header;
}

std::vector<std::string> PriorMapRow(const v1::PriorMap& prior_map) {
  return {IdOf(prior_map.name()),
          prior_map.display_name(),
          std::to_string(prior_map.level()),
          StateText(prior_map.state()),
          std::to_string(prior_map.elements().walls()),
          prior_map.reason()};
}

std::string StateText(v1::PriorMap::State state) { return EnumText(v1::PriorMap::State_Name(state), "STATE_"); }

std::string ElementsText(const v1::PriorMapElements& elements) {
  std::string text = fmt::format("{} walls, {} corners, {} doors, {} rooms, {} shafts", elements.walls(),
                                 elements.corners(), elements.doors(), elements.rooms(), elements.shafts());
  if (elements.metres_per_unit() > 0) text += fmt::format(", {:.5g} m per unit", elements.metres_per_unit());
  return text;
}

std::string AlignmentText(const v1::PriorAlignment& alignment) {
  std::string text = fmt::format(
      "{}{}, {:.5g} m per unit of the plan; {:.0f} % of the maps' walls explained, {:.0f} % of the plan's known walls "
      "contradicted",
      alignment.mirrored() ? "mirrored, " : "", EnumText(v1::PriorAlignment::Model_Name(alignment.model()), "MODEL_"),
      ScaleOf(alignment), 100 * alignment.explained(), 100 * alignment.contradicted());
  if (alignment.tied_walls() > 0) {
    text += fmt::format("; {} walls tie {} maps", alignment.tied_walls(), alignment.maps_size());
  }
  std::string separator = ", and only the plan joins ";
  for (const std::string& map : alignment.joined_maps()) text += std::exchange(separator, ", ") + IdOf(map);
  return text;
}

void PrintPriorMap(const Globals& globals, const std::string& what, const v1::PriorMap& prior_map) {
  if (globals.json) return PrintJson(std::cout, PriorMapToJson(prior_map));
  std::cout << what << " \"" << prior_map.display_name() << "\" (" << prior_map.name() << ")\n";
}

}  // namespace enfilade::cli
