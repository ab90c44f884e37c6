// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/area/area_output.h"

#include <algorithm>
#include <iostream>

#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "fmt/format.h"

namespace enfilade::cli {
namespace {

std::string RobotsText(const v1::MapArea& area) {
  return area.robot_types().empty() ? "all" : fmt::format("{}", fmt::join(area.robot_types(), ", "));
}

std::string SpeedText(const v1::MapArea& area) {
  return area.speed_limit_mps() > 0.0 ? fmt::format("{} m/s", area.speed_limit_mps()) : "";
}

}  // namespace

nlohmann::json MapAreaToJson(const v1::MapArea& area) {
  nlohmann::json document = {
      {"name", area.name()},
      {"display_name", area.display_name()},
      {"kind", KindText(area.kind())},
      {"robot_types", std::vector<std::string>(area.robot_types().begin(), area.robot_types().end())},
      {"outline", nlohmann::json::array()},
      {"etag", area.etag()},
      {"create_time", FormatTime(area.create_time())},
      {"update_time", FormatTime(area.update_time())}};
  for (const v1::Point& corner : area.outline().corners()) {
    document["outline"].push_back(nlohmann::json::array({corner.x(), corner.y()}));
  }
  if (area.speed_limit_mps() > 0.0) document["speed_limit_mps"] = area.speed_limit_mps();
  if (area.has_valid_from()) document["valid_from"] = FormatTime(area.valid_from());
  if (area.has_valid_until()) document["valid_until"] = FormatTime(area.valid_until());
  return document;
}

const std::vector<std::string>& MapAreaHeader() {
  static const std::vector<std::string> header = {"AREA", "NAME", "KIND", "SPEED", "ROBOTS", "HOLDS"};
  return header;
}

std::vector<std::string> MapAreaRow(const v1::MapArea& area) {
  return {IdOf(area.name()), area.display_name(), KindText(area.kind()),
          SpeedText(area),   RobotsText(area),    ValidityText(area)};
}

std::string KindText(v1::MapArea::Kind kind) {
  std::string text = EnumText(v1::MapArea::Kind_Name(kind), "KIND_");
  std::replace(text.begin(), text.end(), ' ', '-');
  return text;
}

std::string ValidityText(const v1::MapArea& area) {
  if (!area.has_valid_from() && !area.has_valid_until()) return "always";
  std::string text;
  if (area.has_valid_from()) text += "from " + FormatTime(area.valid_from()) + " ";
  if (area.has_valid_until()) text += "until " + FormatTime(area.valid_until()) + " ";
  return text + "UTC";
}

void PrintMapArea(const Globals& globals, const std::string& what, const v1::MapArea& area) {
  if (globals.json) return PrintJson(std::cout, MapAreaToJson(area));
  std::cout << what << " " << KindText(area.kind()) << " \"" << area.display_name() << "\" (" << area.name() << ")\n";
}

}  // namespace enfilade::cli
