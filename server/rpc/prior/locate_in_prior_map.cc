// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <string>
#include <utility>
#include <variant>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/geometry.h"
#include "proto/convert/names.h"
#include "proto/convert/record.h"
#include "server/rpc/prior/convert.h"
#include "server/rpc/prior/handlers.h"

namespace enfilade::server {
namespace {

constexpr int kMaxDriveScans = 500;

absl::StatusOr<sensor::PairedScan> DriveScanOf(int index, const v1::LocalizationScan& scan) {
  if (!scan.has_scan()) return InvalidArgument("scans[{}].scan is missing", index);
  v1::Record record;
  record.set_sequence(index + 1);
  *record.mutable_laser_scan() = scan.scan();
  absl::StatusOr<sensor::Record> converted = enfilade::convert::FromProto(record);
  if (!converted.ok()) return WithContext(converted.status(), fmt::format("scans[{}]", index));
  sensor::PairedScan paired{index + 1, std::get<sensor::LaserScan>(std::move(converted->payload)), std::nullopt};
  if (scan.has_pose_odom_robot()) paired.T_odom_robot = enfilade::convert::FromProto(scan.pose_odom_robot());
  return paired;
}

// In the robot's own frame, which no map of the site has.
absl::StatusOr<std::vector<prior::ControlPair>> OwnPairsOf(const SiteId& site,
                                                           const v1::LocateInPriorMapRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const auto given, PairsOf(site, request.pairs()));
  std::vector<prior::ControlPair> pairs;
  for (const storage::PriorMapPair& pair : given) {
    if (!pair.map.empty()) {
      return InvalidArgument(
          "pairs[{}].map is \"{}\": expected none, because points are in the frame of the scans' odometry or of the "
          "session's map",
          pairs.size(), pair.map.value());
    }
    pairs.push_back({pair.point_sheet, pair.point_map});
  }
  return pairs;
}

absl::StatusOr<PlanLocalizationQuery> DriveQueryOf(const SiteId& site, const v1::LocateInPriorMapRequest& request) {
  if (request.scans().empty() == request.session().empty()) {
    return InvalidArgument("{} to locate the robot by: set either scans or session",
                           request.session().empty() ? "nothing" : "scans and a session");
  }
  if (request.scans_size() > kMaxDriveScans) {
    return InvalidArgument("scans has {} scans: at most {}", request.scans_size(), kMaxDriveScans);
  }
  PlanLocalizationQuery query;
  for (int i = 0; i < request.scans_size(); ++i) {
    ENFILADE_ASSIGN_OR_RETURN(sensor::PairedScan scan, DriveScanOf(i, request.scans(i)));
    query.scans.push_back(std::move(scan));
  }
  if (!request.session().empty()) {
    ENFILADE_ASSIGN_OR_RETURN(const auto session, convert::ParseSessionName("session", request.session()));
    if (session.site != site) {
      return InvalidArgument("session is \"{}\": expected one of {}", request.session(), NameOf(site));
    }
    query.session = session.session;
  }
  ENFILADE_ASSIGN_OR_RETURN(query.pairs, OwnPairsOf(site, request));
  return query;
}

v1::PriorMapMode ModeToProto(const RobotInPlan& robot) {
  const prior::PlanState& state = robot.mode.mean;
  v1::PriorMapMode out;
  out.set_mass(robot.mode.mass);
  out.set_sheet_x(robot.point_sheet.x());
  out.set_sheet_y(robot.point_sheet.y());
  *out.mutable_pose_plan_robot() = enfilade::convert::ToProto(Pose2{state.x, state.y, state.yaw});
  out.set_metres_per_unit(robot.metres_per_unit);
  out.set_stretch(std::exp(state.log_stretch));
  out.set_mirrored(state.mirrored);
  for (Eigen::Index row = 0; row < robot.mode.covariance.rows(); ++row) {
    for (Eigen::Index column = 0; column < robot.mode.covariance.cols(); ++column) {
      out.add_covariance(robot.mode.covariance(row, column));
    }
  }
  if (robot.T_world_robot) enfilade::convert::ToProto(*robot.T_world_robot, *out.mutable_pose_world_robot());
  return out;
}

}  // namespace

absl::StatusOr<v1::LocateInPriorMapResponse> LocateInPriorMap(const Services& services, const Call& call,
                                                              const v1::LocateInPriorMapRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const auto name, convert::ParsePriorMapName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const PlanLocalizationQuery query, DriveQueryOf(name.site, request));
  ENFILADE_ASSIGN_OR_RETURN(const storage::PriorMap prior_map,
                            services.prior_maps.Get(call.context(), name.site, name.prior_map));
  ENFILADE_ASSIGN_OR_RETURN(const PlanLocalizationAnswer answer,
                            services.plan_localization.Locate(call.context(), prior_map, query));
  v1::LocateInPriorMapResponse response;
  response.set_confident(answer.confident);
  for (const RobotInPlan& robot : answer.modes) *response.add_modes() = ModeToProto(robot);
  response.set_reason(answer.reason);
  response.set_travelled_m(answer.travelled);
  if (answer.confident_after) response.set_confident_after_m(*answer.confident_after);
  response.set_matched(answer.matched);
  response.set_keyframes(answer.keyframes);
  response.set_metres_per_unit(answer.metres_per_unit);
  response.set_axis_rad(answer.axis);
  response.set_etag(std::to_string(prior_map.etag));
  response.set_graph_version(answer.graph_version);
  return response;
}

}  // namespace enfilade::server
