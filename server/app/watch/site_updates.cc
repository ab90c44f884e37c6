// SPDX-License-Identifier: Apache-2.0
#include "server/app/watch/site_updates.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::server {
namespace {

using storage::CurrentRevision;
using storage::SessionProgress;

// What was committed so late that a look before did not see it may have begun so long before that look.
constexpr DurationNs kLongTransaction = 30 * kNsPerSecond;
// What was removed longer ago may be forgotten.
constexpr DurationNs kRemembered = 24 * 3600 * kNsPerSecond;

std::string_view KeyOf(const SessionProgress& session) { return session.id.value(); }
std::string_view KeyOf(const CurrentRevision& revision) { return revision.map.value(); }

// Those of `now` that are not equally in `before`. Both are in the order of their keys.
template <typename Item>
void AddNew(const std::vector<Item>& before, const std::vector<Item>& now, std::vector<const Item*>& out) {
  auto old = before.begin();
  for (const Item& item : now) {
    while (old != before.end() && KeyOf(*old) < KeyOf(item)) ++old;
    if (old == before.end() || !(*old == item)) out.push_back(&item);
  }
}

void AddCurrentSessions(const ActivityView& activity, SiteUpdate& update) {
  for (const SessionProgress& session : activity.activity.sessions) {
    if (!session.is_over()) update.sessions.push_back(&session);
  }
}

SiteHealth HealthOf(const SiteMoment& moment) {
  const storage::SiteActivity& activity = moment.activity->activity;
  return {static_cast<std::int64_t>(activity.mapping_lag_s), activity.waiting_sessions,
          moment.graph->disconnected_maps};
}

WatchPosition PositionAt(const SiteMoment& moment, std::int64_t report_version) {
  const storage::SiteActivity& activity = moment.activity->activity;
  WatchPosition position{activity.site_created,
                         moment.graph->version(),
                         report_version,
                         activity.time,
                         activity.time,
                         moment.activity->sessions_digest,
                         moment.activity->revisions_digest};
  for (const SessionProgress& session : activity.sessions) {
    if (!session.is_over() && session.finish_time) {
      position.finished_since = std::min(position.finished_since, *session.finish_time);
    }
  }
  return position;
}

bool IsAmong(const std::vector<SitePoses::OfRobot>& robots, const RobotId& id) {
  const auto found =
      std::lower_bound(robots.begin(), robots.end(), id,
                       [](const SitePoses::OfRobot& robot, const RobotId& key) { return robot.report.robot < key; });
  return found != robots.end() && found->report.robot == id;
}

}  // namespace

bool SiteUpdate::empty() const {
  return !reset && !graph_changed && revisions.empty() && removed_sessions.empty() && sessions.empty() &&
         removed_robots.empty() && robots.empty() && !health.has_value();
}

SiteUpdates::SiteUpdates(std::optional<WatchPosition> position, std::set<int> levels)
    : levels_(std::move(levels)), position_(position.value_or(WatchPosition())), resumes_(position.has_value()) {}

absl::StatusOr<SiteUpdate> SiteUpdates::Next(const std::shared_ptr<const SiteMoment>& moment,
                                             const ReadPast& read_past) {
  SiteUpdate update;
  update.moment = moment;
  if (seen_ == moment) return update;
  if (seen_ == nullptr) {
    ENFILADE_RETURN_IF_ERROR(Resume(read_past, update));
  } else if (moment->activity->activity.site_created != position_.site_created ||
             !moment->graph->KnowsChangesSince(position_.graph_version)) {
    return Aborted("the site was deleted and created again: call again");
  } else {
    AddChanges(*seen_, update);
  }
  AddRobots(update);
  if (const SiteHealth health = HealthOf(*moment); health != health_) update.health = health_ = health;
  position_ = PositionAt(*moment, poses_->position().report_version);
  seen_ = moment;
  return update;
}

absl::Status SiteUpdates::Resume(const ReadPast& read_past, SiteUpdate& update) {
  const SiteMoment& moment = *update.moment;
  const storage::SiteActivity& activity = moment.activity->activity;
  const bool is_remembered = position_.site_created == activity.site_created &&
                             position_.time <= activity.time + kLongTransaction &&
                             position_.time > activity.time - kRemembered;
  if (resumes_ && is_remembered && moment.graph->KnowsChangesSince(position_.graph_version)) {
    ENFILADE_ASSIGN_OR_RETURN(storage::PastActivity past, read_past(position_.time - kLongTransaction,
                                                                    position_.finished_since - kLongTransaction));
    update.past = std::make_shared<const storage::PastActivity>(std::move(past));
    AddPast(*update.past, update);
    AddGraph(position_.graph_version, update);
    poses_.emplace(PoseUpdates::Position{position_.graph_version, position_.report_version}, std::set<RobotId>());
    return absl::OkStatus();
  }
  update.reset = true;
  AddAll(update);
  poses_.emplace(PoseUpdates::Position(), std::set<RobotId>());
  return absl::OkStatus();
}

void SiteUpdates::AddPast(const storage::PastActivity& past, SiteUpdate& update) const {
  const ActivityView& activity = *update.moment->activity;
  update.removed_sessions = past.removed_sessions;
  update.removed_robots = past.removed_robots;
  // If those that were not over are as they were, the others have begun and ended since.
  const bool is_unchanged = activity.sessions_digest == position_.sessions_digest;
  if (!is_unchanged) AddCurrentSessions(activity, update);
  for (const SessionProgress& session : past.ended) {
    if (!is_unchanged || session.finish_time >= position_.time - kLongTransaction) update.sessions.push_back(&session);
  }
  if (activity.revisions_digest == position_.revisions_digest) return;
  for (const CurrentRevision& revision : activity.activity.revisions) {
    if (revision.create_time >= position_.time - kLongTransaction) update.revisions.push_back(&revision);
  }
}

void SiteUpdates::AddAll(SiteUpdate& update) const {
  const SiteMoment& moment = *update.moment;
  update.graph_changed = true;
  for (const GraphView::Map& map : moment.graph->maps) update.maps.push_back(&map);
  for (const GraphView::LinkPoint& link_point : moment.graph->link_points) update.link_points.push_back(&link_point);
  for (const CurrentRevision& revision : moment.activity->activity.revisions) update.revisions.push_back(&revision);
  AddCurrentSessions(*moment.activity, update);
}

void SiteUpdates::AddChanges(const SiteMoment& before, SiteUpdate& update) const {
  const ActivityView& now = *update.moment->activity;
  AddGraph(position_.graph_version, update);
  if (update.moment->activity == before.activity) return;
  AddNew(before.activity->activity.revisions, now.activity.revisions, update.revisions);
  AddNew(before.activity->activity.sessions, now.activity.sessions, update.sessions);
  for (const ActivityView::RemovedSession& removed : now.removed_sessions) {
    if (removed.moment > before.activity->moment) update.removed_sessions.push_back(removed.id);
  }
}

void SiteUpdates::AddGraph(std::int64_t since, SiteUpdate& update) const {
  const GraphView& graph = *update.moment->graph;
  if (graph.version() == since) return;
  update.graph_changed = true;
  for (const auto& removed : graph.removed_maps) {
    if (removed.version > since) update.removed_maps.push_back(removed.id);
  }
  for (const auto& removed : graph.removed_link_points) {
    if (removed.version > since) update.removed_link_points.push_back(removed.id);
  }
  for (const GraphView::Map& map : graph.maps) {
    if (map.changed > since) update.maps.push_back(&map);
  }
  for (const GraphView::LinkPoint& link_point : graph.link_points) {
    if (link_point.changed > since) update.link_points.push_back(&link_point);
  }
}

void SiteUpdates::AddRobots(SiteUpdate& update) {
  const SitePoses& poses = *update.moment->poses;
  if (seen_ != nullptr) {
    for (const SitePoses::OfRobot& robot : seen_->poses->robots) {
      if (!IsAmong(poses.robots, robot.report.robot)) update.removed_robots.push_back(robot.report.robot);
    }
  }
  for (const SitePoses::OfRobot* robot : poses_->Next(poses)) {
    const graph::MapInGraph* const map = poses.graph->graph().FindMap(robot->report.map);
    if (levels_.empty() || (map != nullptr && levels_.contains(map->level))) {
      update.robots.push_back(robot);
    } else if (!update.reset) {
      update.removed_robots.push_back(robot->report.robot);  // it may have been on a level that is watched
    }
  }
}

}  // namespace enfilade::server
