// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/base/time.h"
#include "server/app/watch/site_moment.h"
#include "storage/sites/activity_store.h"

namespace enfilade::server {

// How far a watcher of a site has seen. A later watch, also of another server, resumes from it.
struct WatchPosition {
  TimeNs site_created = 0;  // tells sites with the same id apart
  std::int64_t graph_version = 0;
  std::int64_t report_version = 0;  // the greatest
  TimeNs time = 0;                  // of the look at sessions and rasters
  TimeNs finished_since = 0;        // sessions that were finished before had ended by then
  std::uint64_t sessions_digest = 0;
  std::uint64_t revisions_digest = 0;

  friend bool operator==(const WatchPosition&, const WatchPosition&) = default;
};

struct SiteHealth {
  std::int64_t mapping_lag_s = 0;
  std::int64_t waiting_sessions = 0;
  std::int64_t disconnected_maps = 0;

  friend bool operator==(const SiteHealth&, const SiteHealth&) = default;
};

// What a watcher has not seen yet. The pointers are valid as long as `moment` and `past`.
struct SiteUpdate {
  std::shared_ptr<const SiteMoment> moment;
  std::shared_ptr<const storage::PastActivity> past;
  bool reset = false;  // what the watcher has seen before is void
  bool graph_changed = false;
  std::vector<MapId> removed_maps;
  std::vector<LinkPointId> removed_link_points;
  std::vector<const GraphView::Map*> maps;
  std::vector<const GraphView::LinkPoint*> link_points;
  std::vector<const storage::CurrentRevision*> revisions;
  std::vector<SessionId> removed_sessions;
  std::vector<const storage::SessionProgress*> sessions;
  std::vector<RobotId> removed_robots;
  std::vector<const SitePoses::OfRobot*> robots;
  std::optional<SiteHealth> health;

  bool empty() const;
};

// Finds what a watcher of a site has not seen yet. Not thread-safe.
class SiteUpdates {
 public:
  using ReadPast = std::function<absl::StatusOr<storage::PastActivity>(TimeNs since, TimeNs finished_since)>;

  // Resumes from `position`, if it is set and the moment allows it. Robots on `levels` only; empty: on all.
  SiteUpdates(std::optional<WatchPosition> position, std::set<int> levels);

  // What has changed since the last call, and in the first call since the position. `moment` follows those of the last
  // call. `read_past` is called in the first call only, if at all. ABORTED if the site was deleted and created again.
  absl::StatusOr<SiteUpdate> Next(const std::shared_ptr<const SiteMoment>& moment, const ReadPast& read_past);

  // After what the last call gave.
  const WatchPosition& position() const { return position_; }

 private:
  absl::Status Resume(const ReadPast& read_past, SiteUpdate& update);
  void AddPast(const storage::PastActivity& past, SiteUpdate& update) const;
  void AddAll(SiteUpdate& update) const;
  void AddChanges(const SiteMoment& before, SiteUpdate& update) const;
  void AddGraph(std::int64_t since, SiteUpdate& update) const;
  void AddRobots(SiteUpdate& update);

  const std::set<int> levels_;
  WatchPosition position_;
  bool resumes_;
  std::optional<PoseUpdates> poses_;  // set by the first call
  std::shared_ptr<const SiteMoment> seen_;
  std::optional<SiteHealth> health_;
};

}  // namespace enfilade::server
