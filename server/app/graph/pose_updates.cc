// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/pose_updates.h"

#include <algorithm>
#include <utility>

#include "core/base/status_macros.h"

namespace enfilade::server {
namespace {

using OfRobot = SitePoses::OfRobot;

bool IsSamePose(const std::optional<graph::GlobalPose>& a, const std::optional<graph::GlobalPose>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  const PoseWithCovariance& p = a->T_world_robot;
  const PoseWithCovariance& q = b->T_world_robot;
  return p.pose.x == q.pose.x && p.pose.y == q.pose.y && p.pose.yaw == q.pose.yaw && p.covariance == q.covariance;
}

bool AreReportsOf(const SitePoses& poses, const std::vector<storage::RobotPose>& reports) {
  return std::equal(reports.begin(), reports.end(), poses.robots.begin(), poses.robots.end(),
                    [](const storage::RobotPose& report, const OfRobot& known) {
                      return report.robot == known.report.robot && report.version == known.report.version;
                    });
}

const OfRobot* FindRobot(const SitePoses& poses, const RobotId& robot) {
  const auto found = std::lower_bound(poses.robots.begin(), poses.robots.end(), robot,
                                      [](const OfRobot& known, const RobotId& id) { return known.report.robot < id; });
  return found != poses.robots.end() && found->report.robot == robot ? &*found : nullptr;
}

}  // namespace

absl::StatusOr<std::shared_ptr<const SitePoses>> Following(const std::shared_ptr<const SitePoses>& before,
                                                           const std::shared_ptr<const SiteGraph>& graph,
                                                           std::vector<storage::RobotPose> reports) {
  std::sort(reports.begin(), reports.end(),
            [](const storage::RobotPose& a, const storage::RobotPose& b) { return a.robot < b.robot; });
  if (before != nullptr && before->graph == graph && AreReportsOf(*before, reports)) return before;
  auto poses = std::make_shared<SitePoses>();
  poses->moment = before == nullptr ? 1 : before->moment + 1;
  poses->graph = graph;
  poses->robots.reserve(reports.size());
  for (storage::RobotPose& report : reports) {
    OfRobot& robot = poses->robots.emplace_back();
    robot.report = std::move(report);
    robot.changed = poses->moment;
    auto pose = graph->poses.Find(robot.report.map, robot.report.T_map_robot);
    robot.in_graph = !absl::IsNotFound(pose.status());
    if (!robot.in_graph) continue;
    ENFILADE_RETURN_IF_ERROR(pose.status());
    robot.pose = *std::move(pose);
    const OfRobot* const known = before == nullptr ? nullptr : FindRobot(*before, robot.report.robot);
    if (known != nullptr && known->in_graph && known->report.version == robot.report.version &&
        IsSamePose(known->pose, robot.pose)) {
      robot.changed = known->changed;
    }
  }
  return std::shared_ptr<const SitePoses>(std::move(poses));
}

PoseUpdates::PoseUpdates(const Position& resumed, std::set<RobotId> robots)
    : resumed_(resumed), robots_(std::move(robots)), position_(resumed) {}

std::vector<const OfRobot*> PoseUpdates::Next(const SitePoses& poses) {
  position_ = {poses.graph_version(), resumed_.report_version};
  std::vector<const OfRobot*> updates;
  for (const OfRobot& robot : poses.robots) {
    if (!robots_.empty() && !robots_.contains(robot.report.robot)) continue;
    position_.report_version = std::max(position_.report_version, robot.report.version);
    if (!robot.in_graph) continue;
    const bool is_new =
        seen_ ? robot.changed > *seen_
              : poses.graph_version() != resumed_.graph_version || robot.report.version > resumed_.report_version;
    if (is_new) updates.push_back(&robot);
  }
  seen_ = poses.moment;
  return updates;
}

}  // namespace enfilade::server
