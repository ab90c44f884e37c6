// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/pose_updates.h"

#include <algorithm>
#include <utility>

#include "core/base/status_macros.h"

namespace enfilade::server {
namespace {

bool IsSamePose(const std::optional<PoseWithCovariance>& a, const std::optional<PoseWithCovariance>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return a->pose.x == b->pose.x && a->pose.y == b->pose.y && a->pose.yaw == b->pose.yaw &&
         a->covariance == b->covariance;
}

}  // namespace

PoseUpdates::PoseUpdates(const Position& resumed, std::set<RobotId> robots)
    : resumed_(resumed), robots_(std::move(robots)), position_(resumed) {}

bool PoseUpdates::IsNew(const storage::RobotPose& report, std::int64_t graph_version,
                        const std::optional<graph::GlobalPose>& pose) {
  Seen now{report.version, std::nullopt};
  if (pose) now.T_world_robot = pose->T_world_robot;
  const auto [found, is_first] = seen_.try_emplace(report.robot);
  const bool was_seen_before =
      is_first && graph_version == resumed_.graph_version && report.version <= resumed_.report_version;
  const bool is_same =
      found->second.report_version == now.report_version && IsSamePose(found->second.T_world_robot, now.T_world_robot);
  found->second = std::move(now);
  return !was_seen_before && (is_first || !is_same);
}

absl::StatusOr<std::vector<PoseUpdates::Update>> PoseUpdates::Next(const SiteGraph& graph,
                                                                   const std::vector<storage::RobotPose>& reports) {
  const std::int64_t graph_version = graph.graph().version();
  position_ = {graph_version, resumed_.report_version};
  std::vector<Update> updates;
  for (const storage::RobotPose& report : reports) {
    if (!robots_.empty() && !robots_.contains(report.robot)) continue;
    position_.report_version = std::max(position_.report_version, report.version);
    absl::StatusOr<std::optional<graph::GlobalPose>> pose = graph.poses.Find(report.map, report.T_map_robot);
    if (absl::IsNotFound(pose.status())) continue;  // its map is newer than this graph: the next call has it
    ENFILADE_RETURN_IF_ERROR(pose.status());
    if (IsNew(report, graph_version, *pose)) updates.push_back({report, *std::move(pose)});
  }
  return updates;
}

}  // namespace enfilade::server
