// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/graph/watch_global_poses.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/excerpt.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/app/graph/pose_looks.h"
#include "server/rpc/graph/get_global_pose.h"

namespace enfilade::server {
namespace {

constexpr double kMaxRate = 20.0;

struct PoseWatch {
  SiteId site;
  std::set<RobotId> robots;  // empty: all
  PoseUpdates updates;
  PoseLooks::Watcher watcher;
  std::shared_ptr<const SitePoses> poses = nullptr;  // of the last look
  std::int64_t min_graph_version = 0;                // that the first message must have
  bool first = true;
};

// Looks when the site's graph has the version that the watch must have.
void LookFrom(const Services& services, const std::shared_ptr<PoseWatch>& watch,
              std::chrono::steady_clock::time_point deadline,
              const std::function<void(const absl::StatusOr<bool>&)>& then) {
  const auto look = [&services, watch, then](const absl::Status& ready) {
    if (!ready.ok()) return then(ready);
    services.pose_looks.Look(watch->site, [watch, then](const PoseLooks::Result& poses) {
      if (!poses.ok()) return then(poses.status());
      if ((*poses)->graph_version() < watch->min_graph_version) return then(false);  // a look of just before
      watch->min_graph_version = 0;
      then(std::exchange(watch->poses, *poses) != *poses);
    });
  };
  if (watch->min_graph_version == 0) return look(absl::OkStatus());
  services.graph_waits.Await(watch->site, watch->min_graph_version, deadline, look);
}

absl::StatusOr<std::chrono::steady_clock::duration> PeriodOf(double rate_hz) {
  const double rate = rate_hz == 0.0 ? 1.0 : rate_hz;
  if (!(rate > 0.0 && rate <= kMaxRate)) {
    return InvalidArgument("rate_hz is {}: it must lie in (0, {}]", rate_hz, kMaxRate);
  }
  // At least once in an hour, so that the period has a finite number of nanoseconds.
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(std::min(1.0 / rate, 3600.0)));
}

absl::StatusOr<std::set<RobotId>> RobotsOf(const SiteId& site, const v1::WatchGlobalPosesRequest& request) {
  std::set<RobotId> robots;
  for (const std::string& text : request.robots()) {
    ENFILADE_ASSIGN_OR_RETURN(convert::RobotName name, convert::ParseRobotName("robots", text));
    if (name.site != site) return InvalidArgument("robots: {} is of another site", text);
    robots.insert(std::move(name.robot));
  }
  return robots;
}

absl::Status CheckRobots(const Services& services, const storage::CallContext& context, const PoseWatch& watch) {
  for (const RobotId& robot : watch.robots) {
    ENFILADE_RETURN_IF_ERROR(services.robots.Get(context, watch.site, robot).status());
  }
  return absl::OkStatus();
}

// The first message answers also if there is nothing to report: it has the graph version and the resume token.
bool Check(PoseWatch& watch, v1::WatchGlobalPosesResponse& response) {
  const std::vector<const SitePoses::OfRobot*> updates = watch.updates.Next(*watch.poses);
  const std::int64_t graph_version = watch.poses->graph_version();
  response.Clear();
  for (const SitePoses::OfRobot* update : updates) {
    v1::GlobalPose& pose = *response.add_global_poses();
    pose = server::ToProto(update->report, update->pose, graph_version);
    pose.clear_hops();
  }
  response.set_graph_version(graph_version);
  response.set_resume_token(ToResumeToken(watch.updates.position()));
  return std::exchange(watch.first, false) || !updates.empty();
}

}  // namespace

std::string ToResumeToken(const PoseUpdates::Position& position) {
  return fmt::format("{}-{}", position.graph_version, position.report_version);
}

absl::StatusOr<PoseUpdates::Position> FromResumeToken(const std::string& token) {
  PoseUpdates::Position position;
  if (token.empty()) return position;
  const char* const end = token.data() + token.size();
  const auto version = std::from_chars(token.data(), end, position.graph_version);
  if (version.ec == std::errc() && version.ptr != end && *version.ptr == '-') {
    const auto report = std::from_chars(version.ptr + 1, end, position.report_version);
    if (report.ec == std::errc() && report.ptr == end) return position;
  }
  return InvalidArgument("resume_token \"{}\" is not from this server", Excerpt(token, 100));
}

absl::StatusOr<Watch<v1::WatchGlobalPosesResponse>> WatchGlobalPoses(const Services& services, const Call& call,
                                                                     const v1::WatchGlobalPosesRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const std::set<RobotId> robots, RobotsOf(site, request));
  ENFILADE_ASSIGN_OR_RETURN(const auto period, PeriodOf(request.rate_hz()));
  ENFILADE_ASSIGN_OR_RETURN(const PoseUpdates::Position resumed, FromResumeToken(request.resume_token()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t minimum, call.MinGraphVersion());
  ENFILADE_ASSIGN_OR_RETURN(PoseLooks::Watcher watcher, services.pose_looks.Admit(site));
  const auto watch =
      std::make_shared<PoseWatch>(PoseWatch{site, robots, PoseUpdates(resumed, robots), std::move(watcher)});
  watch->min_graph_version = minimum;
  return Watch<v1::WatchGlobalPosesResponse>{
      .period = period,
      .open = [&services,
               watch](const storage::CallContext& context) { return CheckRobots(services, context, *watch); },
      .look =
          [&services, watch, &call](const std::function<void(const absl::StatusOr<bool>&)>& then) {
            LookFrom(services, watch, call.StepContext().deadline, then);
          },
      .check = [watch](const storage::CallContext&, v1::WatchGlobalPosesResponse& message) -> absl::StatusOr<bool> {
        return Check(*watch, message);
      },
      .stopping = [&services] { return services.graphs.stopping(); }};
}

}  // namespace enfilade::server
