// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/drive_mapping.h"

#include <algorithm>
#include <chrono>
#include <set>
#include <utility>

#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "core/grid/overlay.h"
#include "fmt/format.h"
#include "server/app/survey/drive_location.h"
#include "server/app/survey/stored_drives.h"
#include "storage/sessions/all_sessions.h"

namespace enfilade::server {
namespace {

constexpr auto kSurveyTimeout = std::chrono::seconds(60);
constexpr int kPage = 500;
constexpr std::int64_t kPortionBytes = 1 << 20;
// How well the graph predicts where a drive starts in the map of the drives before it.
constexpr double kStartSigma = 0.3;      // m
constexpr double kStartYawSigma = 0.05;  // rad

storage::CallContext SurveyContext() { return storage::CallContext::WithTimeout(kSurveyTimeout); }

absl::StatusOr<std::map<MapId, storage::Map>> ListMaps(const SurveyStores& stores, const SiteId& site) {
  std::map<MapId, storage::Map> maps;
  std::string after;
  while (true) {
    ENFILADE_ASSIGN_OR_RETURN(const std::vector<storage::Map> page,
                              stores.maps.List(SurveyContext(), site, {.limit = kPage, .after = after}));
    for (const storage::Map& map : page) maps.emplace(map.id, map);
    if (page.size() < kPage) return maps;
    after = page.back().id.value();
  }
}

// `sessions`: oldest first.
std::set<SessionId> NewestOfRobots(const std::vector<storage::Session>& sessions) {
  std::map<RobotId, SessionId> newest;
  for (const storage::Session& session : sessions) {
    if (IsMapped(session)) newest.insert_or_assign(session.robot, session.id);
  }
  std::set<SessionId> ids;
  for (const auto& [robot, session] : newest) ids.insert(session);
  return ids;
}

bool IsBefore(const slam::StampedPose& pose, TimeNs time) { return pose.time < time; }

// Between the scans before and after; `trajectory` by time, not empty.
Pose2 PoseAt(const std::vector<slam::StampedPose>& trajectory, TimeNs time) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), time, IsBefore);
  if (after == trajectory.begin()) return after->T_map_robot;
  if (after == trajectory.end()) return trajectory.back().T_map_robot;
  const auto before = std::prev(after);
  return Interpolate(before->T_map_robot, after->T_map_robot,
                     ToSeconds(time - before->time) / ToSeconds(after->time - before->time));
}

class LevelMapper {
 public:
  LevelMapper(const SurveyStores& stores, const SurveyMappingOptions& options, const SiteGraph& graph,
              const SiteId& site, const SurveyRun& run, bool continue_drives,
              const std::set<SessionId>& newest_of_robots)
      : stores_(stores),
        options_(options),
        graph_(graph),
        site_(site),
        run_(run),
        continue_drives_(continue_drives),
        newest_of_robots_(newest_of_robots) {}

  absl::StatusOr<MappedLevel> Run(int level, const std::vector<storage::Session>& sessions,
                                  const std::map<MapId, storage::Map>& maps) {
    level_.survey.level = level;
    ids_before_ = fmt::format("level {}", level);
    std::vector<StoredDrive> left = DrivesOn(level, sessions, maps);
    for (bool grown = true; std::exchange(grown, false);) {
      std::vector<StoredDrive> without_place;
      for (StoredDrive& drive : left) {
        ENFILADE_ASSIGN_OR_RETURN(const bool added, AddDrive(drive, maps));
        if (!added) without_place.push_back(std::move(drive));
        grown = grown || added;
      }
      left = std::move(without_place);  // what was mapped since may show where they are
    }
    AddMaps(sessions, maps);
    return std::move(level_);
  }

 private:
  struct DriveToMap {
    const StoredDrive& stored;
    Environment environment;
    std::string records;    // KeyOf
    bool by_scans = false;  // nothing but its scans may say where it is
    std::optional<slam::ExistingMapEntry> start = {};
  };

  // False: nothing says where the drive is.
  absl::StatusOr<bool> AddDrive(const StoredDrive& stored, const std::map<MapId, storage::Map>& maps) {
    if (!IsDrivenByDoors(stored)) return true;
    ENFILADE_ASSIGN_OR_RETURN(survey::Drive drive, ReadDrive(stored));
    const auto first = std::find_if(drive.begin(), drive.end(),
                                    [](const survey::SurveyedSession& session) { return !session.visits.empty(); });
    if (first == drive.end()) return true;
    const Environment environment = maps.at(first->map).environment;
    const bool begins_level = level_.survey.drives.empty();
    DriveToMap to_map{.stored = stored, .environment = environment, .records = KeyOf(stored, environment)};
    if (!begins_level) to_map.start = StartByGraph(*first);
    to_map.by_scans = !begins_level && !to_map.start;
    const std::string id = Sha256(ids_before_ + (to_map.by_scans ? "?" : "") + BeginningOf(stored, environment));
    ENFILADE_ASSIGN_OR_RETURN(const MappedDrive mapped,
                              run_.cache.Get(id, [&](CachedDrive& cached) { return BringUpToDate(to_map, cached); }));
    if (mapped.grid.cells.empty()) return !to_map.by_scans;
    ids_before_ = id;
    mapped_before_ = Sha256(mapped_before_ + to_map.records);
    if (begins_level) {
      level_.grid = mapped.grid;
    } else {
      ENFILADE_ASSIGN_OR_RETURN(level_.grid, grid::Overlay(level_.grid, mapped.grid));
    }
    PlaceVisits(mapped.trajectory, drive);
    double& factor = level_.survey.variance_factor;
    factor = level_.survey.drives.empty() ? mapped.variance_factor : std::max(factor, mapped.variance_factor);
    ENFILADE_RETURN_IF_ERROR(AddAwaited(stored.back()->id, maps, mapped.trajectory));
    level_.survey.drives.push_back(std::move(drive));
    return true;
  }

  absl::Status BringUpToDate(DriveToMap& drive, CachedDrive& cached) const {
    const bool may_continue = continue_drives_ || cached.before == mapped_before_;
    if (!may_continue || cached.records != drive.records) {
      std::size_t known = 0;
      if (may_continue && cached.growing) known = CountSessionsOf(cached.records, drive.stored, drive.environment);
      if (known == 0) {
        ENFILADE_RETURN_IF_ERROR(Begin(drive, cached));
      }
      if (cached.growing) {
        ENFILADE_RETURN_IF_ERROR(Extend(drive.stored, known, cached));
      }
      cached.records = drive.records;
    }
    // If a drive of a robot that has begun another one goes on nevertheless, it is mapped from its start again.
    if (!newest_of_robots_.contains(drive.stored.back()->id)) cached.growing.reset();
    return absl::OkStatus();
  }

  absl::Status Begin(DriveToMap& drive, CachedDrive& cached) const {
    if (drive.by_scans) {
      ENFILADE_ASSIGN_OR_RETURN(drive.start, StartByScans(drive.stored));
    }
    cached = {};
    cached.before = mapped_before_;
    if (drive.by_scans && !drive.start) return absl::OkStatus();
    const char* profile =
        drive.environment == Environment::kOutdoor ? slam::SlamProfiles::kOutdoor : slam::SlamProfiles::kIndoor;
    cached.growing.emplace(options_.pairing, *options_.slam.Find(profile), ExistingMapOf(drive.start));
    return absl::OkStatus();
  }

  // Where a drive begins, by where the graph or the drives before it have its first map.
  std::optional<slam::ExistingMapEntry> StartByGraph(const survey::SurveyedSession& first) const {
    const std::optional<Pose2> T_level_map = FindPlace(first.map);
    if (!T_level_map) return std::nullopt;
    PoseWithCovariance start{*T_level_map * first.visits.front().T_map_robot, Eigen::Matrix3d::Zero()};
    start.covariance.diagonal() << kStartSigma * kStartSigma, kStartSigma * kStartSigma,
        kStartYawSigma * kStartYawSigma;
    return slam::ExistingMapEntry{start, std::nullopt};
  }

  // Where a drive is that nothing joins to those before it: of a robot that was restarted elsewhere, for example.
  absl::StatusOr<std::optional<slam::ExistingMapEntry>> StartByScans(const StoredDrive& stored) const {
    DriveLocation location(options_.pairing, level_.grid);
    for (const storage::Session* session : stored) {
      if (location.complete()) break;
      ENFILADE_RETURN_IF_ERROR(
          ReadRecords(*session, [&](sensor::Record record) { return location.Add(std::move(record)); }));
    }
    return location.Finish();
  }

  // A level's first drive begins at its origin, the others in what was mapped before.
  std::optional<slam::ExistingMap> ExistingMapOf(const std::optional<slam::ExistingMapEntry>& start) const {
    if (!start) return std::nullopt;
    return slam::ExistingMap{level_.grid, *start};
  }

  // The sessions from the `known`th on are new.
  absl::Status Extend(const StoredDrive& stored, std::size_t known, CachedDrive& cached) const {
    const auto feed = [&](const std::function<void(sensor::Record)>& add) -> absl::Status {
      for (std::size_t i = known; i < stored.size(); ++i) {
        ENFILADE_RETURN_IF_ERROR(ReadRecords(*stored[i], [&](sensor::Record record) {
          add(std::move(record));
          return absl::OkStatus();
        }));
      }
      return absl::OkStatus();
    };
    ENFILADE_ASSIGN_OR_RETURN(MappedDrive mapped, cached.growing->Extend(feed));
    cached.mapped = PackedDrive(std::move(mapped));
    return absl::OkStatus();
  }

  absl::StatusOr<survey::Drive> ReadDrive(const StoredDrive& stored) const {
    survey::Drive drive;
    for (const storage::Session* session : stored) {
      survey::SurveyedSession one{.id = session->id, .map = *session->map};
      if (session->entry.T_map_robot) one.T_map_entry = session->entry.T_map_robot->pose;
      ENFILADE_ASSIGN_OR_RETURN(const std::vector<slam::SlamNode> nodes,
                                stores_.mappings.ListKeyframes(SurveyContext(), site_, session->id));
      for (const slam::SlamNode& node : nodes) one.visits.push_back({node.sequence, node.time, node.T_map_node, {}});
      ENFILADE_ASSIGN_OR_RETURN(const auto reports, stores_.verdicts.ReadReports(SurveyContext(), site_, session->id));
      for (const storage::StoredDoorReport& report : reports) {
        if (report.report.by_hand) return survey::Drive{};
        if (report.report.kind == sensor::DoorReport::Kind::kPassage) {
          one.left = report.report.door_time;
          one.left_width = report.report.width;
        }
      }
      drive.push_back(std::move(one));
    }
    return drive;
  }

  // In the order of the log. An error of `take` ends it.
  absl::Status ReadRecords(const storage::Session& session,
                           const std::function<absl::Status(sensor::Record)>& take) const {
    for (std::int64_t next = 1; next <= session.acknowledged_sequence;) {
      ENFILADE_RETURN_IF_ERROR(run_.proceed());
      ENFILADE_ASSIGN_OR_RETURN(std::vector<sensor::Record> records,
                                stores_.records.Read(SurveyContext(), site_, session.id, next, kPortionBytes));
      if (records.empty()) break;
      next = records.back().sequence + 1;
      for (sensor::Record& record : records) ENFILADE_RETURN_IF_ERROR(take(std::move(record)));
    }
    return absl::OkStatus();
  }

  // Gives each visit its pose on the level; those whose scan the survey could not use are dropped. A session without
  // any is where the one before it ended.
  static void PlaceVisits(const std::vector<slam::StampedPose>& trajectory, survey::Drive& drive) {
    if (trajectory.empty()) return;
    const survey::Visit* before = nullptr;
    for (survey::SurveyedSession& session : drive) {
      std::erase_if(session.visits, [&](survey::Visit& visit) {
        const auto found = std::lower_bound(trajectory.begin(), trajectory.end(), visit.time, IsBefore);
        if (found == trajectory.end() || found->time != visit.time) return true;
        visit.T_level_robot = found->T_map_robot;
        return false;
      });
      if (session.left) session.T_level_left = PoseAt(trajectory, *session.left);
      if (session.visits.empty() && before != nullptr && session.T_map_entry) {
        session.visits.push_back({0, before->time, *session.T_map_entry, before->T_level_robot});
      }
      if (!session.visits.empty()) before = &session.visits.back();
    }
  }

  // The map that the drive's last passage leads into, if it was begun for it. AddMaps drops it if a session is in it.
  absl::Status AddAwaited(const SessionId& last, const std::map<MapId, storage::Map>& maps,
                          const std::vector<slam::StampedPose>& trajectory) {
    ENFILADE_ASSIGN_OR_RETURN(const std::optional<closure::DoorVerdict> verdict,
                              stores_.verdicts.FindPassage(SurveyContext(), site_, last));
    if (!verdict || verdict->decision != closure::DoorDecision::kLinkPointMade || !verdict->entered_map ||
        !verdict->T_map_robot || trajectory.empty()) {
      return absl::OkStatus();
    }
    const auto map = maps.find(*verdict->entered_map);
    if (map == maps.end() || map->second.level != level_.survey.level) return absl::OkStatus();
    if (map->second.state != storage::MapState::kEmpty) return absl::OkStatus();
    ENFILADE_ASSIGN_OR_RETURN(const auto reports, stores_.verdicts.ReadReports(SurveyContext(), site_, last));
    for (const storage::StoredDoorReport& report : reports) {
      if (report.sequence != verdict->sequence) continue;
      const Pose2 T_level_robot = PoseAt(trajectory, report.report.time);
      level_.survey.awaited.push_back({map->first, T_level_robot * Inverse(verdict->T_map_robot->pose), T_level_robot});
    }
    return absl::OkStatus();
  }

  // T_level_map: by the drives before, or by the graph.
  std::optional<Pose2> FindPlace(const MapId& map) const {
    std::optional<Pose2> T_level_world;
    for (const survey::Drive& drive : level_.survey.drives) {
      for (const survey::SurveyedSession& session : drive) {
        const std::optional<Pose2> place = survey::PlaceOf(session);
        if (!place) continue;
        if (session.map == map) return place;
        const auto T_world_other = PlaceInWorld(session.map);
        if (!T_level_world && T_world_other) T_level_world = *place * Inverse(*T_world_other);
      }
    }
    const auto T_world_map = PlaceInWorld(map);
    if (!T_level_world || !T_world_map) return std::nullopt;
    return *T_level_world * *T_world_map;
  }

  std::optional<Pose2> PlaceInWorld(const MapId& map) const {
    const auto pose = graph_.poses.Find(map);
    if (!pose.ok() || !*pose) return std::nullopt;
    return (*pose)->T_world_robot.pose;
  }

  void AddMaps(const std::vector<storage::Session>& sessions, const std::map<MapId, storage::Map>& maps) {
    std::set<MapId> surveyed;
    std::set<SessionId> seen;
    for (const survey::Drive& drive : level_.survey.drives) {
      for (const survey::SurveyedSession& session : drive) {
        surveyed.insert(session.map);
        if (!session.visits.empty()) seen.insert(session.id);
      }
    }
    std::set<MapId> busy;
    for (const storage::Session& session : sessions) {
      if (session.map && !seen.contains(session.id)) busy.insert(*session.map);
    }
    std::erase_if(level_.survey.awaited,
                  [&](const survey::AwaitedMap& map) { return surveyed.contains(map.id) || busy.contains(map.id); });
    for (const MapId& id : surveyed) {
      const storage::Map& map = maps.at(id);
      level_.survey.maps.push_back({.id = id,
                                    .environment = map.environment,
                                    .slam_profile = map.slam_profile,
                                    .root = id == graph_.graph().root(),
                                    .busy = busy.contains(id)});
    }
    for (const graph::LinkPoint* link_point : graph_.graph().ListLinkPoints()) {
      const bool here = std::any_of(link_point->anchors.begin(), link_point->anchors.end(),
                                    [&](const graph::Anchor& anchor) { return surveyed.contains(anchor.map); });
      if (here) level_.survey.link_points.push_back(*link_point);
    }
  }

  const SurveyStores& stores_;
  const SurveyMappingOptions& options_;
  const SiteGraph& graph_;
  const SiteId& site_;
  const SurveyRun& run_;
  const bool continue_drives_;
  const std::set<SessionId>& newest_of_robots_;  // the last mapped session of each robot
  std::string ids_before_;                       // identifies the level and the drives so far
  std::string mapped_before_;                    // identifies their records
  MappedLevel level_;
};

}  // namespace

absl::StatusOr<SiteSurvey> MapSite(const SurveyStores& stores, const SurveyMappingOptions& options,
                                   const SiteGraph& graph, const SiteId& site, const SurveyRun& run) {
  SiteSurvey survey;
  survey.graph_version = graph.graph().version();
  ENFILADE_ASSIGN_OR_RETURN(std::vector<storage::Session> sessions,
                            storage::ListAllSessions(stores.sessions, SurveyContext(), site, {}));
  std::reverse(sessions.begin(), sessions.end());  // oldest first
  ENFILADE_ASSIGN_OR_RETURN(const auto maps, ListMaps(stores, site));
  std::set<int> levels;
  for (const storage::Session& session : sessions) {
    if (session.map && session.state == storage::SessionState::kMapped) survey.sessions.push_back(session.id);
    if (IsMapped(session) && maps.contains(*session.map)) levels.insert(maps.at(*session.map).level);
  }
  const bool continue_drives = run.continue_drives || std::any_of(sessions.begin(), sessions.end(), IsUnderWay);
  const std::set<SessionId> newest = NewestOfRobots(sessions);
  for (const int level : levels) {
    LevelMapper mapper(stores, options, graph, site, run, continue_drives, newest);
    ENFILADE_ASSIGN_OR_RETURN(MappedLevel mapped, mapper.Run(level, sessions, maps));
    if (!mapped.survey.drives.empty()) survey.levels.push_back(std::move(mapped));
  }
  run.cache.DropUnused();
  return survey;
}

}  // namespace enfilade::server
