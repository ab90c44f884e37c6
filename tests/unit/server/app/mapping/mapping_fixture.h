// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include <string>
#include <utility>
#include <vector>

#include "core/slam/mapper/log_mapper.h"
#include "server/app/mapping/session_mapping.h"
#include "tests/fakes/in_memory_stores.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/slam/synthetic_drive.h"
#include "tests/unit/server/app/test_values.h"

namespace enfilade::server {

// Site "campus" with robot "r" and map "hall", and a drive around a room of 20 x 10 m as a log.
class MappingFixture : public ::testing::Test {
 protected:
  MappingFixture() {
    stores_.database.AddSite(site_);
    stores_.database.AddRobot(site_, RobotId("r"));
    EXPECT_OK(stores_.maps.Create(Soon(), MakeMap(site_, "hall"), ""));
  }

  // Odometry between the scans, not at their times; 268 records.
  static const std::vector<sensor::Record>& Log() {
    static const auto* log = new std::vector<sensor::Record>(MakeLog());
    return *log;
  }
  // The robot's pose at each scan of the log, in the frame of the first one.
  static std::vector<Pose2> Truth() {
    std::vector<Pose2> poses = Poses();
    const Pose2 first = poses.front();
    for (Pose2& pose : poses) pose = Between(first, pose);
    return poses;
  }
  // What the offline tool makes of the log.
  static const slam::SlamMap& OfflineMap() {
    static const auto* map = new slam::SlamMap(MapOffline());
    return *map;
  }

  SessionId NewSession(const std::string& id, const std::string& map = "hall") {
    EXPECT_OK(stores_.sessions.Create(Soon(), MakeSession(site_, id, map), ""));
    return SessionId(id);
  }
  // Records `begin` to `end` of the log (without the last one).
  void Append(const SessionId& session, std::size_t begin, std::size_t end) {
    const std::vector<sensor::Record> records(Log().begin() + static_cast<std::ptrdiff_t>(begin),
                                              Log().begin() + static_cast<std::ptrdiff_t>(end));
    const storage::RecordBatch batch{site_, session, records, {}};
    for (const auto& result : stores_.records.AppendGroup(Soon(), absl::MakeConstSpan(&batch, 1))) EXPECT_OK(result);
  }
  void Finish(const SessionId& session) {
    const std::int64_t last = Session(session).highest_sequence;
    EXPECT_OK(stores_.sessions.Finish(Soon(), site_, session, last));
  }
  // A finished session with the whole log.
  SessionId NewFinishedSession(const std::string& id, const std::string& map = "hall") {
    SessionId session = NewSession(id, map);
    Append(session, 0, Log().size());
    Finish(session);
    return session;
  }
  storage::Session Session(const SessionId& session) {
    auto found = stores_.sessions.Get(Soon(), site_, session);
    EXPECT_OK(found);
    return *found;
  }
  slam::SlamMap StoredMap(const SessionId& session) {
    const auto stored = stores_.mappings.Load(Soon(), site_, session);
    EXPECT_OK(stored);
    return stored.ok() && stored->has_value() ? (*stored)->map : slam::SlamMap();
  }
  void ExpectOfflineMap(const SessionId& session) {
    const slam::SlamMap stored = StoredMap(session);
    EXPECT_EQ(stored.nodes, OfflineMap().nodes);
    EXPECT_EQ(stored.submaps, OfflineMap().submaps);
    EXPECT_EQ(stored.loop_closures, OfflineMap().loop_closures);
    EXPECT_EQ(stored.trajectory, OfflineMap().trajectory);
    EXPECT_EQ(Session(session).mapped_sequence, static_cast<std::int64_t>(Log().size()));
  }
  SessionMappingStores mapping_stores() const {
    return {stores_.mappings,  stores_.records,     stores_.sessions, stores_.blobs,
            stores_.revisions, stores_.robot_poses, stores_.maps};
  }

  const SiteId site_{"campus"};
  const MapId hall_{"hall"};
  testing::InMemoryStores stores_;

 private:
  static std::vector<Pose2> Poses() { return testing::Drive({{3, 3}, {15, 3}, {15, 7}, {3, 7}, {3, 3}}, 0.4); }
  static std::vector<sensor::Record> MakeLog() {
    const auto walls =
        testing::WallsFromText({"##########", "#........#", "#...##...#", "#........#", "##########"}, 2.0);
    std::vector<sensor::Record> log;
    for (sensor::PairedScan& scan : testing::Record(walls, Poses(), {}, {}, 1)) {
      log.push_back({0, sensor::Odometry{scan.scan.time - 10'000'000, *scan.T_odom_robot}});
      log.push_back({0, std::move(scan.scan)});
    }
    for (std::size_t i = 0; i < log.size(); ++i) log[i].sequence = static_cast<std::int64_t>(i) + 1;
    return log;
  }
  static slam::SlamMap MapOffline() {
    slam::LogMapper mapper({}, slam::SlamOptions());
    for (const sensor::Record& record : Log()) mapper.Add(record);
    mapper.Finish();
    slam::SlamMap map;
    map.Apply(mapper.TakeDelta());
    return map;
  }
};

}  // namespace enfilade::server
