// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/prior/prior_locate_stored.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>
#include <utility>
#include <vector>

#include "client/cli/commands/prior/prior_fit_files.h"
#include "client/cli/log_mapping.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sdk/api/localization.h"
#include "client/sdk/api/prior_maps.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/prior_map_service.grpc.pb.h"
#include "fmt/format.h"

namespace enfilade::cli {
namespace {

// A name that is neither a file nor a plan is more often a misspelt file.
absl::StatusOr<v1::PriorMap> FindStoredPlan(const client::Connection& connection, const Globals& globals,
                                            const std::string& plan) {
  absl::StatusOr<v1::PriorMap> found = client::FindPriorMap(connection, SiteId(globals.site), plan);
  if (found.ok()) return found;
  return WithContext(found.status(), fmt::format("\"{}\" is no file; as a plan of {}", plan, SiteNameOf(globals)));
}

absl::StatusOr<v1::LocateInPriorMapRequest> DriveRequestOf(const Globals& globals, const std::string& name,
                                                           const LocateInStoredPlanOptions& options) {
  v1::LocateInPriorMapRequest request;
  request.set_name(name);
  Pose2 T_odom_start;  // the pairs' frame in that of the request
  if (options.session.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(sources::LogReader reader, sources::LogReader::Open(options.log, options.reading));
    ENFILADE_ASSIGN_OR_RETURN(const std::vector<sensor::PairedScan> scans, ReadScans(reader));
    if (scans.empty()) return InvalidArgument("{}: no scan in it", options.log);
    request = client::MakeLocateInPriorMapRequest(name, scans);
    T_odom_start = scans.front().T_odom_robot.value_or(Pose2{});
  } else {
    request.set_session(ResourceNameOf(globals, "sessions", options.session));
  }
  if (options.pairs.empty()) return request;
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<prior::ControlPair> pairs, ReadPairs(options.pairs));
  if (pairs.empty()) return InvalidArgument("{}: no pairs in it", options.pairs);
  for (const prior::ControlPair& pair : pairs) {
    const Eigen::Vector2d point = T_odom_start * pair.point_map;
    v1::ControlPair& sent = *request.add_pairs();
    sent.set_sheet_x(pair.point_sheet.x());
    sent.set_sheet_y(pair.point_sheet.y());
    sent.set_x_m(point.x());
    sent.set_y_m(point.y());
  }
  return request;
}

nlohmann::json RowsOfFour(const google::protobuf::RepeatedField<double>& numbers) {
  nlohmann::json rows = nlohmann::json::array();
  for (int i = 0; i + 4 <= numbers.size(); i += 4) {
    rows.push_back(std::vector<double>(numbers.begin() + i, numbers.begin() + i + 4));
  }
  return rows;
}

// The same names as of a plan in a file.
nlohmann::json ModeToJson(const v1::PriorMapMode& mode, double metres_per_unit) {
  nlohmann::json document = {{"mass", mode.mass()},
                             {"plan_px", {mode.sheet_x(), mode.sheet_y()}},
                             {"plan_m", {mode.pose_plan_robot().x(), mode.pose_plan_robot().y()}},
                             {"yaw", mode.pose_plan_robot().yaw()},
                             {"scale", mode.metres_per_unit() / metres_per_unit},
                             {"metres_per_px", mode.metres_per_unit()},
                             {"stretch", mode.stretch()},
                             {"mirrored", mode.mirrored()},
                             {"covariance", RowsOfFour(mode.covariance())}};
  if (mode.has_pose_world_robot()) document["pose_world_robot"] = PoseToJson(mode.pose_world_robot());
  return document;
}

nlohmann::json LocatedToJson(const v1::LocateInPriorMapResponse& response) {
  nlohmann::json document = {{"confident", response.confident()},
                             {"confident_after_m", nullptr},
                             {"travelled_m", response.travelled_m()},
                             {"metres_per_unit", response.metres_per_unit()},
                             {"axis", response.axis_rad()},
                             {"reason", response.reason()},
                             {"matched", response.matched()},
                             {"keyframes", response.keyframes()},
                             {"etag", response.etag()},
                             {"graph_version", response.graph_version()},
                             {"modes", nlohmann::json::array()}};
  if (response.has_confident_after_m()) document["confident_after_m"] = response.confident_after_m();
  for (const v1::PriorMapMode& mode : response.modes()) {
    document["modes"].push_back(ModeToJson(mode, response.metres_per_unit()));
  }
  return document;
}

void PrintModes(const v1::LocateInPriorMapResponse& response) {
  std::vector<std::vector<std::string>> rows;
  for (const v1::PriorMapMode& mode : response.modes()) {
    const v1::Pose2& world = mode.pose_world_robot().pose();
    const double variance = mode.covariance_size() == 16 ? mode.covariance(0) + mode.covariance(5) : 0;
    rows.push_back(
        {fmt::format("{:.0f} %", 100 * mode.mass()), fmt::format("{:.1f} {:.1f}", mode.sheet_x(), mode.sheet_y()),
         fmt::format("{:.1f}", mode.pose_plan_robot().yaw() / kDegree), fmt::format("{:.2f}", std::sqrt(variance)),
         fmt::format("{:.4g}", mode.metres_per_unit()), mode.mirrored() ? "mirrored" : "",
         mode.has_pose_world_robot() ? fmt::format("{:.2f} {:.2f} {:.2f}", world.x(), world.y(), world.yaw()) : "-"});
  }
  if (!rows.empty()) {
    PrintTable(std::cout, {"MASS", "X Y ON THE SHEET", "YAW DEG", "SIGMA M", "M PER UNIT", "", "IN THE WORLD"}, rows);
  }
}

}  // namespace

absl::Status LocateInStoredPlan(const Globals& globals, const LocateInStoredPlanOptions& options) {
  if (options.log.empty() == options.session.empty()) {
    return InvalidArgument("prior locate: give either a LOG or --session");
  }
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::PriorMap plan, FindStoredPlan(connection, globals, options.plan));
  ENFILADE_ASSIGN_OR_RETURN(const v1::LocateInPriorMapRequest request, DriveRequestOf(globals, plan.name(), options));
  ENFILADE_ASSIGN_OR_RETURN(const auto response,
                            connection.Call(&v1::PriorMapService::Stub::LocateInPriorMap, request));
  if (globals.json) {
    PrintJson(std::cout, LocatedToJson(response));
    return absl::OkStatus();
  }
  PrintModes(response);
  std::cout << fmt::format("{} after {:.1f} m: {}\n", response.confident() ? "located" : "not certain",
                           response.travelled_m(), response.reason());
  return absl::OkStatus();
}

}  // namespace enfilade::cli
