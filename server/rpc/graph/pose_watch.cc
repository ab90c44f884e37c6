// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/graph/pose_watch.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/graph/get_global_pose.h"

namespace enfilade::server {
namespace {

constexpr double kMaxRate = 20.0;

}  // namespace

// Two numbers with a dash between.
absl::StatusOr<PoseWatch::Token> PoseWatch::ParseToken(const std::string& text) {
  Token token;
  if (text.empty()) return token;
  const char* const end = text.data() + text.size();
  const auto version = std::from_chars(text.data(), end, token.graph_version);
  if (version.ec == std::errc() && version.ptr != end && *version.ptr == '-') {
    const auto report = std::from_chars(version.ptr + 1, end, token.report_version);
    if (report.ec == std::errc() && report.ptr == end) return token;
  }
  return InvalidArgument("resume_token is none that this server gives: \"{}\"", text.substr(0, 100));
}

absl::StatusOr<PoseWatch> PoseWatch::Create(const v1::WatchGlobalPosesRequest& request) {
  PoseWatch watch;
  ENFILADE_ASSIGN_OR_RETURN(watch.site_, convert::ParseSiteName("parent", request.parent()));
  for (const std::string& text : request.robots()) {
    ENFILADE_ASSIGN_OR_RETURN(convert::RobotName name, convert::ParseRobotName("robots", text));
    if (name.site != watch.site_) return InvalidArgument("robots: {} is of another site", text);
    watch.robots_.insert(std::move(name.robot));
  }
  const double rate = request.rate_hz() == 0.0 ? 1.0 : request.rate_hz();
  if (!(rate > 0.0 && rate <= kMaxRate)) {
    return InvalidArgument("rate_hz is {}: it must lie in (0, {}]", request.rate_hz(), kMaxRate);
  }
  // No rarer than once in an hour, so that the period has a finite number of nanoseconds.
  watch.period_ = std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(std::min(1.0 / rate, 3600.0)));
  ENFILADE_ASSIGN_OR_RETURN(watch.token_, ParseToken(request.resume_token()));
  return watch;
}

absl::Status PoseWatch::CheckRobots(const Services& services, const storage::CallContext& context) const {
  for (const RobotId& robot : robots_) {
    ENFILADE_RETURN_IF_ERROR(services.robots.Get(context, site_, robot).status());
  }
  return absl::OkStatus();
}

bool PoseWatch::IsNew(const storage::RobotPose& report, std::int64_t graph_version, const v1::GlobalPose& pose) {
  const auto [found, is_first] = sent_.try_emplace(report.robot);
  Sent now{report.version, pose.pose_world_robot().SerializeAsString()};
  const bool was_sent_before =
      is_first && graph_version == token_.graph_version && report.version <= token_.report_version;
  const bool is_same = found->second.report_version == now.report_version && found->second.pose == now.pose;
  found->second = std::move(now);
  return !was_sent_before && (is_first || !is_same);
}

absl::StatusOr<bool> PoseWatch::Check(const Services& services, const storage::CallContext& context,
                                      v1::WatchGlobalPosesResponse& response) {
  if (first_) ENFILADE_RETURN_IF_ERROR(CheckRobots(services, context));
  ENFILADE_ASSIGN_OR_RETURN(const auto graph, services.graphs.Get(context, site_));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<storage::RobotPose> reports, services.robot_poses.List(context, site_));
  const std::int64_t version = graph->graph().version();
  response.Clear();
  Token next{version, token_.report_version};
  for (const storage::RobotPose& report : reports) {
    if (!robots_.empty() && !robots_.contains(report.robot)) continue;
    next.report_version = std::max(next.report_version, report.version);
    absl::StatusOr<v1::GlobalPose> pose = GlobalPoseOf(*graph, report);
    if (absl::IsNotFound(pose.status())) continue;  // its map is newer than this graph: the next look has it
    ENFILADE_RETURN_IF_ERROR(pose.status());
    if (!IsNew(report, version, *pose)) continue;
    pose->clear_hops();
    *response.add_global_poses() = *std::move(pose);
  }
  // What the token tells is only for robots that this stream has not told of.
  response.set_graph_version(version);
  response.set_resume_token(fmt::format("{}-{}", next.graph_version, next.report_version));
  return std::exchange(first_, false) || response.global_poses_size() > 0;
}

}  // namespace enfilade::server
