// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/drive_mapping.h"

#include <algorithm>
#include <set>
#include <span>
#include <utility>

#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "core/grid/overlay.h"
#include "core/grid/wall_agreement.h"
#include "fmt/format.h"
#include "server/app/survey/cabin_reader.h"
#include "server/app/survey/chained_sessions.h"
#include "server/app/survey/drive_location.h"
#include "server/app/survey/drive_trajectory.h"
#include "server/app/survey/lift_rides.h"
#include "server/app/survey/stored_drives.h"
#include "spdlog/spdlog.h"
#include "storage/sessions/all_sessions.h"

namespace enfilade::server {
namespace {

constexpr int kPage = 500;
// How well the graph predicts where a drive starts in the map of the drives before it.
constexpr double kStartSigma = 0.3;      // m
constexpr double kStartYawSigma = 0.05;  // rad
// Of a drive that is located by its scans, the share of walls that may lie where the drives before it have seen free
// ground, or the other way round: furniture is moved. The map of a drive bends by less than the tolerance.
constexpr double kMostContradicted = 0.3;
constexpr double kWallTolerance = 0.25;  // m

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
    if (IsSettled(session)) newest.insert_or_assign(session.robot, session.id);
  }
  std::set<SessionId> ids;
  for (const auto& [robot, session] : newest) ids.insert(session);
  return ids;
}

// What is known of all drives of the site.
struct SiteDrives {
  bool continue_drives = false;
  std::set<SessionId> newest_of_robots;  // the last mapped session of each robot
  LiftRides rides;
};

class LevelMapper {
 public:
  LevelMapper(const DriveReader& reader, const SurveyMappingOptions& options, const SiteGraph& graph,
              const SurveyRun& run, const SiteDrives& site)
      : reader_(reader), options_(options), graph_(graph), run_(run), site_(site) {}

  absl::StatusOr<MappedLevel> Run(int level, const std::vector<storage::Session>& sessions,
                                  const std::map<MapId, storage::Map>& maps) {
    level_.survey.level = level;
    ids_before_ = fmt::format("level {}", level);
    std::vector<StoredDrive> left = DrivesOn(level, sessions, maps);
    for (StoredDrive& drive : left) {
      std::erase_if(drive,
                    [&](const storage::Session* session) { return site_.rides.from_elsewhere.contains(session->id); });
    }
    std::erase_if(left, [](const StoredDrive& drive) { return drive.empty(); });
    for (const MapId& cabin : site_.rides.cabins) {
      if (maps.at(cabin).level != level) level_.survey.cabins.insert(cabin);
    }
    for (bool grown = true; std::exchange(grown, false);) {
      std::vector<StoredDrive> without_place;
      for (StoredDrive& drive : left) {
        ENFILADE_ASSIGN_OR_RETURN(const bool added, AddDrive(drive, maps));
        if (!added) without_place.push_back(std::move(drive));
        grown = grown || added;
      }
      left = std::move(without_place);  // what was mapped since may show where they are
    }
    ENFILADE_RETURN_IF_ERROR(AddMaps(sessions, maps));
    return std::move(level_);
  }

 private:
  struct DriveToMap {
    const StoredDrive& stored;
    const survey::Drive& sessions;  // the same ones, with all their visits
    Environment environment;
    std::string records;               // KeyOf
    std::optional<TimeNs> until = {};  // what is later was recorded on another level, or beyond a door to it
    bool by_scans = false;             // nothing but its scans may say where it is
    std::optional<slam::ExistingMapEntry> start = {};
  };

  // False: nothing says where the drive is.
  absl::StatusOr<bool> AddDrive(const StoredDrive& stored, const std::map<MapId, storage::Map>& maps) {
    ENFILADE_ASSIGN_OR_RETURN(const bool is_driven_by_doors, reader_.IsDrivenByDoors(stored));
    if (!is_driven_by_doors) return true;
    ENFILADE_ASSIGN_OR_RETURN(ReadDrive read, reader_.Read(stored));
    survey::Drive& drive = read.sessions;
    const auto first = std::find_if(drive.begin(), drive.end(),
                                    [](const survey::SurveyedSession& session) { return !session.visits.empty(); });
    if (first == drive.end()) return true;
    const Environment environment = maps.at(first->map).environment;
    const bool begins_level = level_.survey.drives.empty();
    const CabinReader cabins(reader_, site_.rides);
    ENFILADE_ASSIGN_OR_RETURN(const std::optional<closure::DoorVerdict> verdict,
                              reader_.FindVerdict(stored.back()->id));
    DriveToMap to_map{
        .stored = stored, .sessions = drive, .environment = environment, .records = KeyOf(stored, environment)};
    if (verdict && LeadsToAnotherLevel(stored.back()->id, *verdict, maps)) {
      ENFILADE_ASSIGN_OR_RETURN(to_map.until, reader_.FindEndOnLevel(drive.back()));
    }
    if (to_map.until) {
      to_map.records += fmt::format(" until {}", *to_map.until);
      // Once it is cut at the cabin's door, nothing shows where the ride began.
      if (!site_.rides.going_on.contains(drive.back().id)) {
        drive.back().cabin = cabins.EntryOf(*verdict, drive.back(), *to_map.until);
      }
    }
    if (!begins_level) to_map.start = StartByGraph(*first);
    to_map.by_scans = !begins_level && !to_map.start;
    const std::string id = Sha256(ids_before_ + (to_map.by_scans ? "?" : "") + BeginningOf(stored, environment));
    ENFILADE_ASSIGN_OR_RETURN(const slam::ChainedMap mapped,
                              run_.cache.Get(id, [&](CachedDrive& cached) { return BringUpToDate(to_map, cached); }));
    if (mapped.grid.cells.empty()) return !to_map.by_scans;
    if (to_map.by_scans && IsElsewhere(stored, mapped.grid)) return false;
    ids_before_ = id;
    mapped_before_ = Sha256(mapped_before_ + to_map.records);
    if (begins_level) {
      level_.grid = mapped.grid;
    } else {
      ENFILADE_ASSIGN_OR_RETURN(level_.grid, grid::Overlay(level_.grid, mapped.grid));
    }
    for (const slam::StampedPose& pose : mapped.trajectory) {
      level_.trajectory.push_back(pose.T_map_robot.translation());
    }
    for (const ReportedDoor& door : read.doors) {
      if (const auto passage = PassageAt(mapped.trajectory, door)) level_.passages.push_back(*passage);
    }
    PlaceVisits(mapped.trajectory, drive);
    double& factor = level_.survey.variance_factor;
    factor = level_.survey.drives.empty() ? mapped.variance_factor : std::max(factor, mapped.variance_factor);
    if (begins_level) {
      ENFILADE_RETURN_IF_ERROR(cabins.PlaceCabin(*stored.front(), drive.front(), level_.survey));
    }
    ENFILADE_RETURN_IF_ERROR(cabins.AddRideBegun(drive.back(), level_.survey));
    if (verdict) {
      ENFILADE_RETURN_IF_ERROR(AddAwaited(stored.back()->id, *verdict, maps, mapped.trajectory));
    }
    level_.survey.drives.push_back(std::move(drive));
    return true;
  }

  // Whether the drive's map, located by scans alone, lies across what was mapped before. It is then left out, until
  // others have mapped more.
  bool IsElsewhere(const StoredDrive& drive, const grid::OccupancyGrid& mapped) const {
    const double share = grid::CompareWalls(level_.grid, mapped, kWallTolerance).contradicted_share();
    if (share <= kMostContradicted) return false;
    spdlog::info("the drive from session {} on is left out: where its scans place it, {:.0f} % of the walls contradict",
                 drive.front()->id.value(), 100.0 * share);
    return true;
  }

  // Whether the door at the session's end leads there: by the session that follows, or by the verdict as long as none
  // is mapped.
  bool LeadsToAnotherLevel(const SessionId& session, const closure::DoorVerdict& verdict,
                           const std::map<MapId, storage::Map>& maps) const {
    if (site_.rides.next.contains(session)) return true;
    if (!verdict.entered_map) return false;
    const auto map = maps.find(*verdict.entered_map);
    return map != maps.end() && map->second.level != level_.survey.level;
  }

  absl::Status BringUpToDate(DriveToMap& drive, CachedDrive& cached) const {
    const bool may_continue = site_.continue_drives || cached.before == mapped_before_;
    if (!may_continue || cached.records != drive.records) {
      std::size_t known = 0;
      if (may_continue && cached.chain) known = CountSessionsOf(cached.chained, drive.stored, drive.environment);
      // All of them: before it was known that the last one leads to another level.
      if (known == drive.stored.size()) known = 0;
      if (known == 0) {
        ENFILADE_RETURN_IF_ERROR(Begin(drive, cached));
      }
      if (cached.chain) {
        ENFILADE_RETURN_IF_ERROR(Extend(drive, known, cached));
      }
      cached.records = drive.records;
    }
    // If a drive of a robot that has begun another one goes on nevertheless, it is mapped from its start again.
    if (!site_.newest_of_robots.contains(drive.stored.back()->id)) cached.chain.reset();
    return absl::OkStatus();
  }

  absl::Status Begin(DriveToMap& drive, CachedDrive& cached) const {
    if (drive.by_scans) {
      ENFILADE_ASSIGN_OR_RETURN(drive.start, StartByScans(drive));
    }
    cached = {};
    cached.before = mapped_before_;
    if (drive.by_scans && !drive.start) return absl::OkStatus();
    cached.chain.emplace(OptionsOf(drive), ExistingMapOf(drive.start));
    return absl::OkStatus();
  }

  const slam::SlamOptions& OptionsOf(const DriveToMap& drive) const {
    return *options_.slam.Find(drive.environment == Environment::kOutdoor ? slam::SlamProfiles::kOutdoor
                                                                          : slam::SlamProfiles::kIndoor);
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
  absl::StatusOr<std::optional<slam::ExistingMapEntry>> StartByScans(const DriveToMap& drive) const {
    DriveLocation location(options_.pairing, level_.grid);
    for (const storage::Session* session : drive.stored) {
      if (location.complete()) break;
      ENFILADE_RETURN_IF_ERROR(reader_.sessions().ReadRecords(
          *session, drive.until, [&](sensor::Record record) { return location.Add(std::move(record)); }));
    }
    return location.Finish();
  }

  // A level's first drive begins at its origin, the others in what was mapped before.
  std::optional<slam::ExistingMap> ExistingMapOf(const std::optional<slam::ExistingMapEntry>& start) const {
    if (!start) return std::nullopt;
    return slam::ExistingMap{level_.grid, *start};
  }

  // The sessions from the `known`th on are new.
  absl::Status Extend(const DriveToMap& drive, std::size_t known, CachedDrive& cached) const {
    ChainedSessions sessions(reader_.sessions(), options_.pairing, OptionsOf(drive),
                             std::span(drive.stored).subspan(known), drive.until);
    while (!sessions.done()) {
      ENFILADE_RETURN_IF_ERROR(sessions.AppendNext(*cached.chain));
      const auto end = drive.stored.begin() + static_cast<std::ptrdiff_t>(known + sessions.appended());
      cached.chained = KeyOf({drive.stored.begin(), end}, drive.environment);
    }
    cached.mapped = PackedDrive(cached.chain->Finish());
    return absl::OkStatus();
  }

  // The map that the drive's last passage leads into, if it was begun for it. AddMaps drops it if a session is in it.
  absl::Status AddAwaited(const SessionId& last, const closure::DoorVerdict& verdict,
                          const std::map<MapId, storage::Map>& maps, const DriveTrajectory& trajectory) {
    if (verdict.decision != closure::DoorDecision::kLinkPointMade || !verdict.entered_map || !verdict.T_map_robot ||
        trajectory.empty() || LeadsToAnotherLevel(last, verdict, maps)) {
      return absl::OkStatus();
    }
    const auto map = maps.find(*verdict.entered_map);
    if (map == maps.end() || map->second.state != storage::MapState::kEmpty) return absl::OkStatus();
    ENFILADE_ASSIGN_OR_RETURN(const std::optional<sensor::DoorReport> passage, reader_.FindPassage(last));
    if (!passage) return absl::OkStatus();
    const Pose2 T_level_robot = PoseAt(trajectory, passage->time);
    level_.survey.awaited.push_back({map->first, T_level_robot * Inverse(verdict.T_map_robot->pose), T_level_robot});
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

  absl::Status AddMaps(const std::vector<storage::Session>& sessions, const std::map<MapId, storage::Map>& maps) {
    std::set<MapId> surveyed;
    std::set<SessionId> seen;
    for (const survey::Drive& drive : level_.survey.drives) {
      for (const survey::SurveyedSession& session : drive) {
        surveyed.insert(session.map);
        if (!session.visits.empty()) seen.insert(session.id);
      }
    }
    std::set<MapId> busy;
    std::map<MapId, std::vector<survey::Ride>> rides;
    for (const storage::Session& session : sessions) {
      if (!session.map || seen.contains(session.id)) continue;
      if (site_.rides.from_elsewhere.contains(session.id)) {
        ENFILADE_ASSIGN_OR_RETURN(survey::Ride ride, reader_.ReadRide(session.id));
        rides[*session.map].push_back(std::move(ride));
      } else {
        busy.insert(*session.map);
      }
    }
    std::erase_if(level_.survey.awaited, [&](const survey::AwaitedMap& map) {
      return surveyed.contains(map.id) || busy.contains(map.id) || rides.contains(map.id);
    });
    for (const MapId& id : surveyed) {
      const storage::Map& map = maps.at(id);
      level_.survey.maps.push_back({.id = id,
                                    .environment = map.environment,
                                    .slam_profile = map.slam_profile,
                                    .root = id == graph_.graph().root(),
                                    .busy = busy.contains(id),
                                    .pinned = map.pinned,
                                    .rides = rides[id]});
    }
    for (const graph::LinkPoint* link_point : graph_.graph().ListLinkPoints()) {
      level_.survey.link_points.push_back(*link_point);
    }
    return absl::OkStatus();
  }

  const DriveReader& reader_;
  const SurveyMappingOptions& options_;
  const SiteGraph& graph_;
  const SurveyRun& run_;
  const SiteDrives& site_;
  std::string ids_before_;     // identifies the level and the drives so far
  std::string mapped_before_;  // identifies their records
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
    if (!IsSettled(session)) continue;
    survey.sessions.push_back(session.id);
    if (const auto map = maps.find(*session.map); map != maps.end()) levels.insert(map->second.level);
  }
  const DriveReader reader(stores, site, run.proceed);
  SiteDrives drives;
  drives.continue_drives = run.continue_drives || std::any_of(sessions.begin(), sessions.end(), IsUnderWay);
  drives.newest_of_robots = NewestOfRobots(sessions);
  ENFILADE_ASSIGN_OR_RETURN(drives.rides, FindLiftRides(reader, sessions, maps));
  std::set<LinkPointId> seen_through;
  ENFILADE_ASSIGN_OR_RETURN(const auto joins, stores.plan_joins.List(SurveyContext(), site));
  for (const storage::PlanJoin& join : joins) {
    if (!join.undone) seen_through.insert(join.link_point);
  }
  ENFILADE_ASSIGN_OR_RETURN(const auto gaps, reader.FindGaps());
  for (const int level : levels) {
    LevelMapper mapper(reader, options, graph, run, drives);
    ENFILADE_ASSIGN_OR_RETURN(MappedLevel mapped, mapper.Run(level, sessions, maps));
    mapped.survey.seen_through = seen_through;
    mapped.survey.gaps = gaps;
    if (!mapped.survey.drives.empty()) survey.levels.push_back(std::move(mapped));
  }
  run.cache.DropUnused();
  return survey;
}

}  // namespace enfilade::server
