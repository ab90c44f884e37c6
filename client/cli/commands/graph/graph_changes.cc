// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/graph/graph_changes.h"

#include <google/protobuf/util/json_util.h>

#include <cmath>
#include <iostream>
#include <memory>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/graph/linkpoint_output.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/geometry/pose2.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "io/file.h"

namespace enfilade::cli {
namespace {

nlohmann::json PreviewToJson(const v1::PreviewGraphResponse& preview) {
  nlohmann::json json{{"graph_version", preview.graph_version()},
                      {"chi2_before", preview.chi2_before()},
                      {"chi2_after", preview.chi2_after()},
                      {"degrees_of_freedom", preview.degrees_of_freedom()},
                      {"moved_maps", nlohmann::json::array()},
                      {"residuals", nlohmann::json::array()},
                      {"disconnected_maps", std::vector<std::string>(preview.disconnected_maps().begin(),
                                                                     preview.disconnected_maps().end())}};
  for (const v1::MovedMap& moved : preview.moved_maps()) {
    nlohmann::json item{{"map", moved.map()}};
    if (moved.has_pose_world_map_before()) item["pose_world_map_before"] = PoseToJson(moved.pose_world_map_before());
    if (moved.has_pose_world_map_after()) item["pose_world_map_after"] = PoseToJson(moved.pose_world_map_after());
    json["moved_maps"].push_back(std::move(item));
  }
  for (const v1::LinkPointResidual& residual : preview.residuals()) {
    json["residuals"].push_back({{"link_point", residual.link_point()},
                                 {"chi2_before", residual.chi2_before()},
                                 {"chi2_after", residual.chi2_after()},
                                 {"gate", residual.gate()},
                                 {"switched_off_before", residual.switched_off_before()},
                                 {"switched_off_after", residual.switched_off_after()}});
  }
  return json;
}

std::string HowMoved(const v1::MovedMap& moved) {
  if (!moved.has_pose_world_map_before()) return "joined to the root";
  if (!moved.has_pose_world_map_after()) return "no longer joined to the root";
  const v1::Pose2& from = moved.pose_world_map_before().pose();
  const v1::Pose2& to = moved.pose_world_map_after().pose();
  return fmt::format("{:.3f} m, {:.2f} deg", std::hypot(to.x() - from.x(), to.y() - from.y()),
                     std::abs(WrapAngle(to.yaw() - from.yaw())) / kDegree);
}

std::string UseAfter(const v1::LinkPointResidual& residual) {
  if (residual.switched_off_after()) return residual.switched_off_before() ? "still switched off" : "switched off";
  return residual.switched_off_before() ? "used again" : "used";
}

void PrintPreview(const v1::PreviewGraphResponse& preview) {
  std::vector<std::vector<std::string>> maps;
  for (const v1::MovedMap& moved : preview.moved_maps()) maps.push_back({IdOf(moved.map()), HowMoved(moved)});
  PrintTable(std::cout, {"MAP", "MOVED"}, maps);
  std::vector<std::vector<std::string>> residuals;
  for (const v1::LinkPointResidual& residual : preview.residuals()) {
    residuals.push_back({IdOf(residual.link_point()), fmt::format("{:.3g}", residual.chi2_before()),
                         fmt::format("{:.3g}", residual.chi2_after()), fmt::format("{:.3g}", residual.gate()),
                         UseAfter(residual)});
  }
  std::cout << '\n';
  PrintTable(std::cout, {"LINK POINT", "CHI2 BEFORE", "AFTER", "LIMIT", "THEN"}, residuals);
  std::cout << fmt::format("\nchi2 of the graph {:.3g} -> {:.3g}; nothing was changed\n", preview.chi2_before(),
                           preview.chi2_after());
  for (const std::string& map : preview.disconnected_maps()) {
    std::cout << "not joined to the root: " << IdOf(map) << '\n';
  }
}

void PrintChanged(const Globals& globals, const v1::ChangeGraphResponse& changed) {
  if (globals.json) {
    nlohmann::json link_points = nlohmann::json::array();
    for (const v1::LinkPoint& link_point : changed.link_points()) link_points.push_back(LinkPointToJson(link_point));
    PrintJson(std::cout, {{"graph_version", changed.graph_version()}, {"link_points", std::move(link_points)}});
    return;
  }
  std::cout << "changed: graph version " << changed.graph_version() << '\n';
  std::vector<std::vector<std::string>> rows;
  for (const v1::LinkPoint& link_point : changed.link_points()) rows.push_back(LinkPointRow(link_point));
  PrintTable(std::cout, LinkPointHeader(), rows);
}

absl::Status ChangeByFile(const Globals& globals, const std::string& path, bool preview) {
  ENFILADE_ASSIGN_OR_RETURN(const std::string text, io::ReadFile(path));
  v1::ChangeGraphRequest request;
  const auto parsed = google::protobuf::util::JsonStringToMessage(text, &request);
  if (!parsed.ok()) {
    return InvalidArgument("{}: {}. Expected {{\"changes\": [...]}} as in the API", path,
                           std::string(parsed.message().data(), parsed.message().size()));
  }
  if (!request.site().empty() && request.site() != SiteNameOf(globals)) {
    return InvalidArgument("{} is for {}: use --site", path, request.site());
  }
  return RunGraphChanges(globals, ConnectionOf(globals),
                         std::vector<v1::GraphChange>(request.changes().begin(), request.changes().end()), preview);
}

}  // namespace

absl::Status RunGraphChanges(const Globals& globals, const client::Connection& connection,
                             const std::vector<v1::GraphChange>& changes, bool preview) {
  if (preview) {
    v1::PreviewGraphRequest request;
    request.set_site(SiteNameOf(globals));
    request.mutable_changes()->Add(changes.begin(), changes.end());
    ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&v1::GraphService::Stub::PreviewGraph, request));
    globals.json ? PrintJson(std::cout, PreviewToJson(response)) : PrintPreview(response);
    return absl::OkStatus();
  }
  v1::ChangeGraphRequest request;
  request.set_site(SiteNameOf(globals));
  request.mutable_changes()->Add(changes.begin(), changes.end());
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&v1::GraphService::Stub::ChangeGraph, request));
  PrintChanged(globals, response);
  return absl::OkStatus();
}

void AddGraphChange(CLI::App& graph, const Globals& globals) {
  const auto path = std::make_shared<std::string>();
  const auto preview = std::make_shared<bool>(false);
  CLI::App* change = AddCommand(graph, "change", "Make several changes of link points together, all or none",
                                [&globals, path, preview] { return ChangeByFile(globals, *path, *preview); });
  change->add_option("FILE", *path, "JSON: the body of ChangeGraph, {\"changes\": [...]}")->required();
  change->add_flag("--preview", *preview, kPreviewHelp);
  change->footer("Example: enfilade graph change changes.json --preview");
}

}  // namespace enfilade::cli
