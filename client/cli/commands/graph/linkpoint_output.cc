// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/graph/linkpoint_output.h"

#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "fmt/format.h"

namespace enfilade::cli {
namespace {

std::string KindName(const v1::LinkPoint& link_point) {
  return EnumText(v1::LinkPoint::Kind_Name(link_point.kind()), "KIND_");
}
std::string StateName(const v1::LinkPoint& link_point) {
  return EnumText(v1::LinkPoint::State_Name(link_point.state()), "STATE_");
}
std::string UseName(const v1::LinkPoint& link_point) {
  return EnumText(v1::LinkPoint::Use_Name(link_point.use()), "USE_");
}

}  // namespace

nlohmann::json LinkPointToJson(const v1::LinkPoint& link_point) {
  nlohmann::json json{{"name", link_point.name()},
                      {"kind", KindName(link_point)},
                      {"tag", link_point.tag()},
                      {"candidate", link_point.anchors_size() < 2},
                      {"anchors", nlohmann::json::array()},
                      {"direction_map", link_point.direction_map()},
                      {"difficulty", link_point.difficulty()},
                      {"state", StateName(link_point)},
                      {"use", UseName(link_point)},
                      {"pinned", link_point.pinned()},
                      {"graph_version", link_point.graph_version()},
                      {"etag", link_point.etag()}};
  for (const v1::Anchor& anchor : link_point.anchors()) {
    nlohmann::json place = PoseToJson(anchor.pose_map_place());
    place["map"] = anchor.map();
    json["anchors"].push_back(std::move(place));
  }
  if (link_point.has_pose_world_place()) json["pose_world_place"] = PoseToJson(link_point.pose_world_place());
  if (link_point.has_state_valid_until()) {
    json["state_valid_until"] = FormatTime(link_point.state_valid_until());
  }
  return json;
}

const std::vector<std::string>& LinkPointHeader() {
  static const std::vector<std::string> header = {"LINK POINT", "KIND", "MAPS", "WORLD X Y", "STATE", "USE", "TAG"};
  return header;
}

std::vector<std::string> LinkPointRow(const v1::LinkPoint& link_point) {
  std::string maps;
  for (const v1::Anchor& anchor : link_point.anchors()) maps += (maps.empty() ? "" : " - ") + IdOf(anchor.map());
  const v1::Pose2& pose = link_point.pose_world_place().pose();
  return {IdOf(link_point.name()),
          KindName(link_point),
          link_point.anchors_size() < 2 ? maps + " (candidate)" : maps,
          link_point.has_pose_world_place() ? fmt::format("{:.2f} {:.2f}", pose.x(), pose.y()) : "-",
          StateName(link_point),
          UseName(link_point),
          link_point.tag()};
}

}  // namespace enfilade::cli
