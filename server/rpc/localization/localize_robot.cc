// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <string>
#include <utility>
#include <variant>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/geometry.h"
#include "proto/convert/names.h"
#include "proto/convert/record.h"
#include "server/rpc/link_point/convert.h"
#include "server/rpc/localization/handlers.h"

namespace enfilade::server {
namespace {

constexpr int kMaxScans = 100;
constexpr int kMaxResults = 50;
constexpr int kDefaultResults = 5;

absl::StatusOr<localization::QueryScan> QueryScanOf(int index, const v1::LocalizationScan& scan) {
  if (!scan.has_scan()) return InvalidArgument("scans[{}].scan is missing", index);
  v1::Record record;
  record.set_sequence(1);
  *record.mutable_laser_scan() = scan.scan();
  absl::StatusOr<sensor::Record> converted = enfilade::convert::FromProto(record);
  if (!converted.ok()) return WithContext(converted.status(), fmt::format("scans[{}]", index));
  localization::QueryScan query{std::get<sensor::LaserScan>(std::move(converted->payload)), std::nullopt};
  if (scan.has_pose_odom_robot()) query.T_odom_robot = enfilade::convert::FromProto(scan.pose_odom_robot());
  return query;
}

absl::StatusOr<QueryImage> QueryImageOf(const v1::LocalizationImage& image) {
  if (image.content().empty()) return InvalidArgument("image.content is empty");
  if (image.content().size() > static_cast<std::size_t>(sensor::kMaxBlobBytes)) {
    return InvalidArgument("image.content has {} bytes: at most {}", image.content().size(), sensor::kMaxBlobBytes);
  }
  switch (image.camera()) {
    case v1::Image::CAMERA_UNSPECIFIED:
    case v1::Image::CAMERA_FRONT:
      return QueryImage{sensor::Camera::kFront, image.content()};
    case v1::Image::CAMERA_REAR:
      return QueryImage{sensor::Camera::kRear, image.content()};
    default:
      return InvalidArgument("image.camera is {}, which is unknown", static_cast<int>(image.camera()));
  }
}

absl::StatusOr<LocalizationPrior> PriorOf(const SiteId& site, const v1::LocalizationPrior& prior) {
  LocalizationPrior result;
  if (!prior.map().empty()) {
    ENFILADE_ASSIGN_OR_RETURN(result.map, MapOfSite("prior.map", site, prior.map()));
  }
  if (prior.has_pose_map_robot()) {
    ENFILADE_ASSIGN_OR_RETURN(result.T_map_robot,
                              enfilade::convert::FromProto("prior.pose_map_robot", prior.pose_map_robot()));
  }
  if (prior.has_level()) result.level = prior.level();
  return result;
}

absl::StatusOr<LocalizationQuery> QueryOf(const SiteId& site, const v1::LocalizeRobotRequest& request) {
  if (request.scans().empty() && !request.has_image()) {
    return InvalidArgument("nothing to locate the robot by: set scans, image or both");
  }
  if (request.scans_size() > kMaxScans) {
    return InvalidArgument("scans has {} scans: at most {}", request.scans_size(), kMaxScans);
  }
  LocalizationQuery query;
  for (int i = 0; i < request.scans_size(); ++i) {
    ENFILADE_ASSIGN_OR_RETURN(localization::QueryScan scan, QueryScanOf(i, request.scans(i)));
    query.scans.push_back(std::move(scan));
  }
  if (request.has_image()) {
    ENFILADE_ASSIGN_OR_RETURN(query.image, QueryImageOf(request.image()));
  }
  ENFILADE_ASSIGN_OR_RETURN(query.prior, PriorOf(site, request.prior()));
  return query;
}

v1::LocatedPose LocatedPoseOf(const SiteId& site, const RobotPoseInMap& pose) {
  v1::LocatedPose out;
  out.set_map(convert::NameOf(convert::MapName{site, pose.map}));
  enfilade::convert::ToProto(pose.T_map_robot, *out.mutable_pose_map_robot());
  if (pose.T_world_robot) enfilade::convert::ToProto(*pose.T_world_robot, *out.mutable_pose_world_robot());
  out.set_score(pose.score);
  out.set_log_odds_behind(pose.odds_behind);
  out.set_confident(pose.confident);
  return out;
}

v1::LocatedPlace LocatedPlaceOf(const SiteId& site, const RankedPlace& place) {
  v1::LocatedPlace out;
  out.set_link_point(convert::NameOf(convert::LinkPointName{site, place.link_point}));
  out.set_map(convert::NameOf(convert::MapName{site, place.map}));
  if (place.T_map_view) *out.mutable_pose_map_view() = enfilade::convert::ToProto(*place.T_map_view);
  out.set_matches(place.matches);
  out.set_accepted(place.accepted);
  return out;
}

}  // namespace

absl::StatusOr<v1::LocalizeRobotResponse> LocalizeRobot(const Services& services, const Call& call,
                                                        const v1::LocalizeRobotRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("site", request.site()));
  if (request.max_results() < 0 || request.max_results() > kMaxResults) {
    return InvalidArgument("max_results is {}: expected 0 to {}", request.max_results(), kMaxResults);
  }
  const std::size_t limit =
      static_cast<std::size_t>(request.max_results() == 0 ? kDefaultResults : request.max_results());
  ENFILADE_ASSIGN_OR_RETURN(const LocalizationQuery query, QueryOf(site, request));
  ENFILADE_ASSIGN_OR_RETURN(const LocalizationAnswer answer,
                            services.localization.Localize(call.context(), site, query));
  v1::LocalizeRobotResponse response;
  for (std::size_t i = 0; i < std::min(limit, answer.poses.size()); ++i) {
    *response.add_poses() = LocatedPoseOf(site, answer.poses[i]);
  }
  for (std::size_t i = 0; i < std::min(limit, answer.places.size()); ++i) {
    *response.add_places() = LocatedPlaceOf(site, answer.places[i]);
  }
  response.set_reason(answer.reason);
  response.set_maps_searched(answer.maps_searched);
  response.set_graph_version(answer.graph_version);
  return response;
}

}  // namespace enfilade::server
