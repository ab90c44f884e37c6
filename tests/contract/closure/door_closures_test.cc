// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/door_closures.h"

#include <gmock/gmock.h>

#include <map>
#include <set>

#include "client/simulator/sensors/sensors.h"
#include "tests/contract/closure/door_closures_fixture.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

TEST_F(DoorClosuresTest, TheCanonicalCampusIsMappedWithoutHelp) {
  const std::vector<DrivenSession> drive = DriveThroughDoors(WithImagesAndClouds());
  ASSERT_THAT(DoorsOf(drive), ElementsAre("candidate", "L0", "L1", "candidate", "L2", "L3", "L4"));
  const std::vector<SessionId> sessions = MapAll(drive);
  EXPECT_THAT(Decisions(sessions), ElementsAre("candidate made", "link point made", "link point made", "candidate made",
                                               "link point made", "candidate promoted", "candidate promoted"));
  EXPECT_EQ(Value("SELECT count(*) FROM maps"), "4");
  EXPECT_EQ(Value("SELECT count(*) FROM link_points WHERE anchor_count = 2"), "5");
  EXPECT_EQ(Value("SELECT count(*) FROM link_points WHERE anchor_count <> 2"), "0");
  // The fifth session is in the first map again, the sixth in the third.
  EXPECT_EQ(MapOf(sessions[4]), map_);
  EXPECT_EQ(MapOf(sessions[5]), MapOf(sessions[2]));
  // Every map that sees a place has images and a cloud of it, and where the robot was when it took them.
  EXPECT_EQ(Value("SELECT count(*) FROM link_point_anchors a WHERE NOT EXISTS (SELECT FROM link_point_evidence e"
                  " WHERE e.link_point_id = a.link_point_id AND e.map_id = a.map_id AND e.kind = 2 AND e.x IS NOT NULL)"
                  " OR NOT EXISTS (SELECT FROM link_point_evidence e WHERE e.link_point_id = a.link_point_id"
                  " AND e.map_id = a.map_id AND e.kind = 3)"),
            "0");
  EXPECT_NE(Value("SELECT count(*) FROM image_features"), "0");
  // The graph was optimised without a request.
  EXPECT_NE(Value("SELECT count(*) FROM graph_versions WHERE cause = 7"), "0");
}

TEST_F(DoorClosuresTest, TheRobotComesBackThroughACandidateAndGoesThroughAKnownDoorAgain) {
  const std::vector<DrivenSession>& drive = DriveInTwoRooms();
  ASSERT_THAT(DoorsOf(drive), ElementsAre("candidate", "south", "north", "south"));
  const std::vector<SessionId> sessions = MapAll(drive);
  EXPECT_THAT(Decisions(sessions),
              ElementsAre("candidate made", "link point made", "candidate promoted", "link point recognised"));
  EXPECT_EQ(Value("SELECT count(*) FROM maps"), "2");
  EXPECT_EQ(Value("SELECT count(*) FROM link_points"), "2");
  EXPECT_EQ(MapOf(sessions[2]), map_);
  EXPECT_EQ(MapOf(sessions[3]), MapOf(sessions[1]));
  // The two doors are 5 m apart in both maps, whichever way they were found.
  EXPECT_EQ(Value("SELECT count(*) FROM link_point_anchors a JOIN link_point_anchors b"
                  " ON a.map_id = b.map_id AND a.link_point_id < b.link_point_id"
                  " WHERE abs(sqrt((a.x - b.x) ^ 2 + (a.y - b.y) ^ 2) - 5) < 0.4"),
            "2");
}

TEST_F(DoorClosuresTest, WithoutImagesAndCloudsTheScansDecideAndTheVerdictSaysWhatWasMissing) {
  DoorDriveOptions options = InTwoRooms();
  options.simulation.image_hz = 0.0;
  options.simulation.cloud_hz = 0.0;
  const std::vector<DrivenSession> drive = DriveThroughDoors(options);
  const std::vector<SessionId> sessions = MapAll(drive);
  ASSERT_THAT(Decisions(sessions),
              ElementsAre("candidate made", "link point made", "candidate promoted", "link point recognised"));
  EXPECT_EQ(MapOf(sessions[2]), map_);
  EXPECT_THAT(Verdicts(sessions[0])[0].reason, HasSubstr("neither images nor clouds"));
  const std::vector<closure::DoorVerdict> second = Verdicts(sessions[1]);
  EXPECT_THAT(second[0].reason, HasSubstr("the scans show where the robot is"));
  ASSERT_THAT(second[0].comparisons, SizeIs(2));  // the candidate, and the door that it came through before
  EXPECT_THAT(second[0].comparisons[0].reason, HasSubstr("the robot has no images behind the door"));
  EXPECT_EQ(second[0].comparisons[0].image_matches, std::nullopt);
  EXPECT_EQ(second[0].comparisons[0].rmse, std::nullopt);
}

TEST_F(DoorClosuresTest, DamagedImagesAndCloudsCountAsMissing) {
  std::vector<DrivenSession> drive = DriveInTwoRooms();
  Change(drive[0], [](const sensor::Record& record, std::string bytes) {
    return bytes.substr(0, 101) + std::to_string(record.sequence);
  });
  const std::vector<SessionId> sessions = MapAll(drive);
  ASSERT_THAT(Decisions(sessions),
              ElementsAre("candidate made", "link point made", "candidate promoted", "link point recognised"));
  const closure::DoorVerdict verdict = Verdicts(sessions[1])[0];
  EXPECT_THAT(verdict.reason, HasSubstr("an image cannot be read"));
  EXPECT_THAT(verdict.reason, HasSubstr("a cloud cannot be read"));
  ASSERT_FALSE(verdict.comparisons.empty());
  EXPECT_EQ(verdict.comparisons[0].image_matches, std::nullopt);
  EXPECT_EQ(verdict.comparisons[0].rmse, std::nullopt);
}

TEST_F(DoorClosuresTest, ABlackImageShowsNothingAndSpeaksNeitherForNorAgainst) {
  std::vector<DrivenSession> drive = DriveInTwoRooms();
  simulator::CameraFrame black{.width = 512, .height = 384, .grey = {}, .depth = {}};
  black.grey.resize(512 * 384, 0);
  ASSERT_OK_AND_ASSIGN(const std::string png, black.GreyPng());
  Change(drive[0], [&](const sensor::Record& record, std::string bytes) {
    return std::holds_alternative<sensor::Image>(record.payload) ? png : bytes;
  });
  drive.resize(2);
  const std::vector<SessionId> sessions = MapAll(drive);
  Decisions(sessions);
  const closure::DoorVerdict verdict = Verdicts(sessions[1])[0];
  EXPECT_THAT(verdict.reason, HasSubstr("an image shows nothing: 0 features"));
  for (const closure::DoorComparison& compared : verdict.comparisons) EXPECT_EQ(compared.image_matches, std::nullopt);
}

TEST_F(DoorClosuresTest, TheCloudOfAnotherPlaceOutweighsImagesThatAgree) {
  std::vector<DrivenSession> drive = DriveInTwoRooms();
  std::string other;
  Change(drive[1], [&](const sensor::Record& record, std::string bytes) {
    if (std::holds_alternative<sensor::PointCloud>(record.payload) && other.empty()) other = bytes;
    return bytes;
  });
  Change(drive[0], [&](const sensor::Record& record, std::string bytes) {
    return std::holds_alternative<sensor::PointCloud>(record.payload) ? other : bytes;
  });
  drive.resize(2);
  const std::vector<SessionId> sessions = MapAll(drive);
  ASSERT_THAT(Decisions(sessions), ElementsAre("candidate made", "link point made", "link point made"));
  const closure::DoorVerdict verdict = Verdicts(sessions[1])[0];
  bool images_agreed = false;
  for (const closure::DoorComparison& compared : verdict.comparisons) {
    images_agreed = images_agreed || compared.images_agree;
    EXPECT_FALSE(compared.accepted) << compared.reason;
  }
  EXPECT_TRUE(images_agreed);
}

TEST_F(DoorClosuresTest, SessionsAfterNoPassageStartAMapThatNothingJoins) {
  const std::vector<SessionId> sessions = MapAll(std::vector<DrivenSession>(2));
  EXPECT_NE(MapOf(sessions[1]), map_);
  EXPECT_EQ(Value("SELECT count(*) FROM link_points"), "0");
  EXPECT_EQ(Value("SELECT initial_x IS NULL FROM sessions WHERE session_id = 's2'"), "t");
}

TEST_F(DoorClosuresTest, APassageAtWhichNothingWasMappedIsJoinedByOdometry) {
  sensor::DoorReport report;
  report.time = report.door_time = 9;
  report.kind = sensor::DoorReport::Kind::kPassage;
  report.entered_level = 3;
  std::vector<DrivenSession> drive(2);
  drive[0].log = {{1, report}};
  const std::vector<SessionId> sessions = MapAll(drive);
  ASSERT_THAT(Decisions(sessions), ElementsAre("link point made"));
  EXPECT_THAT(Verdicts(sessions[0])[0].reason, HasSubstr("nothing was mapped"));
  EXPECT_EQ(Value("SELECT level FROM maps WHERE display_name = 'Map 1'"), "3");
  EXPECT_EQ(Value("SELECT count(*) FROM link_points"), "1");
}

TEST_F(DoorClosuresTest, ADoorBehindARideIsNoSurerThanTheRide) {
  std::vector<DrivenSession> drive = DriveInTwoRooms();
  drive.resize(2);
  bool rode = false;
  for (sensor::Record& record : drive[0].log) {
    auto* report = std::get_if<sensor::DoorReport>(&record.payload);
    if (report == nullptr || report->kind != sensor::DoorReport::Kind::kPassage) continue;
    report->entered_level = 1;
    rode = true;
  }
  ASSERT_TRUE(rode);
  MapAll(drive);
  const std::string yaw_sigma =
      "(SELECT sqrt(covariance[9]) FROM link_point_anchors WHERE map_id = 'hall'"
      " AND link_point_id IN (SELECT link_point_id FROM link_points WHERE anchor_count = 2))";
  EXPECT_EQ(Value("SELECT " + yaw_sigma + " > " + std::to_string(closure::DoorClosureOptions().ride_yaw_sigma)), "t")
      << Value("SELECT " + yaw_sigma);
}

// Reports of one site that cannot be read, more than are looked at together, and older than those of another site.
TEST_F(DoorClosuresTest, ASiteWhoseReportsCannotBeJudgedHoldsUpNoOther) {
  workers_.reset();
  database_.Sql(
      "SET session_replication_role = replica;"
      "INSERT INTO enfilade.sessions (site_id, session_id, robot_id, map_id, state, acknowledged_sequence,"
      " highest_sequence, door_reports, create_time, finish_time)"
      " SELECT 'campus', 'stuck-' || i, 'r1', 'hall', 3, 1, 1, 1, now() - interval '1 day', now() - interval '1 day'"
      " FROM generate_series(1, 40) i;"
      "INSERT INTO enfilade.session_records (site_id, session_id, sequence, time_ns, kind, payload)"
      " SELECT 'campus', 'stuck-' || i, 1, 9, 6, '\\x00' FROM generate_series(1, 40) i");
  const SiteId other("other");
  ASSERT_OK(sites_.Create(Soon(), MakeSite(other, "Other"), ""));
  storage::Robot robot;
  robot.site = other;
  robot.id = robot_;
  robot.display_name = "Robot";
  ASSERT_OK(robots_.Create(Soon(), robot, ""));
  ASSERT_OK(maps_.Create(Soon(), MakeMap(other, MapId("yard"), "Yard"), ""));
  const storage::Session first = MakeSession(other, SessionId("first"), robot_, MapId("yard"));
  ASSERT_OK(sessions_.Create(Soon(), first, ""));
  ASSERT_OK(sessions_.Finish(Soon(), other, first.id, 0));
  storage::Session next = MakeSession(other, SessionId("next"), robot_, std::nullopt);
  next.entry.previous = first.id;
  ASSERT_OK(sessions_.Create(Soon(), next, ""));
  Restart();
  const auto entered = [&] { return sessions_.Get(Soon(), other, next.id)->map.has_value(); };
  for (int i = 0; i < 300 * kSlowdown && !entered(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_TRUE(entered()) << "no passage was reported: it is in a new map";
}

TEST_F(DoorClosuresTest, WorkersThatEndInBetweenLeaveNothingHalfDone) {
  const std::vector<SessionId> sessions = SendAll(DriveInTwoRooms());
  for (int i = 0; i < 8; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    Restart();
  }
  AwaitMapped(sessions);
  EXPECT_THAT(Decisions(sessions),
              ElementsAre("candidate made", "link point made", "candidate promoted", "link point recognised"));
  EXPECT_EQ(Value("SELECT count(*) FROM link_points"), "2");
  EXPECT_EQ(Value("SELECT count(*) FROM maps"), "2");
}

class RoomsThatLookAlike : public DoorClosuresTest, public ::testing::WithParamInterface<bool> {};

// If all rooms look the same, only the path there tells one door from another.
TEST_P(RoomsThatLookAlike, AreNotConfused) {
  DoorDriveOptions options = GetParam() ? WithImagesAndClouds() : DoorDriveOptions();
  options.campus = "lookalike";
  const std::vector<DrivenSession> drive = DriveThroughDoors(options);
  ASSERT_GT(drive.size(), 5U);
  const std::vector<SessionId> sessions = MapAll(drive);
  Decisions(sessions);
  std::map<MapId, std::set<std::string>> areas;  // of the campus, by the server's map
  for (std::size_t i = 0; i < drive.size(); ++i) {
    // A session reaches a metre beyond its last door, so that it ends in the area that the next one is in.
    areas[MapOf(sessions[i])].insert(i == 0 ? "corridor" : drive[i - 1].area);
  }
  for (const auto& [map, seen] : areas) EXPECT_THAT(seen, SizeIs(1)) << map.value();
}

INSTANTIATE_TEST_SUITE_P(WithAndWithoutImages, RoomsThatLookAlike, ::testing::Bool());

}  // namespace
}  // namespace enfilade::testing
