#include "server/app/closure/door_closures.h"

#include <gmock/gmock.h>

#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <set>
#include <thread>

#include "client/simulator/sensors.h"
#include "core/base/sha256.h"
#include "server/app/graph/graph_optimizer.h"
#include "server/app/mapping.h"
#include "tests/contract/storage/store_test.h"
#include "tests/support/door_drive.h"
#include "tests/support/status_matchers.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

const char* InWords(DoorDecision decision) {
  switch (decision) {
    case DoorDecision::kCandidateMade:
      return "candidate made";
    case DoorDecision::kCandidateKnown:
      return "candidate known";
    case DoorDecision::kCandidatePromoted:
      return "candidate promoted";
    case DoorDecision::kLinkPointRecognised:
      return "link point recognised";
    case DoorDecision::kLinkPointMade:
      return "link point made";
    case DoorDecision::kNotJudged:
      return "not judged";
  }
  return "?";
}

// What the server does with sessions, without gRPC: mapping, the graph and its optimisation, closures at doors.
class Workers {
 public:
  Workers(postgres::Pool& pool, const ClosureOptions& options)
      : pool_(pool), metrics_(*server::Metrics::Create("")), options_(options) {
    mapping_.emplace(
        server::ServerOptions::Mapping{}, SlamOptions(),
        server::SessionMappingStores{mappings_, records_, sessions_, blobs_, revisions_, robot_poses_, maps_},
        *metrics_, [this] { wake_.Wake(); });
    closures_.emplace(options_,
                      server::ClosureStores{sessions_, records_, mappings_, blobs_, features_, maps_, link_points_,
                                            verdicts_, leases_},
                      graphs_, wake_, [this] { mapping_->Wake(); });
  }

 private:
  postgres::Pool& pool_;
  const SessionStore sessions_{pool_};
  const RecordStore records_{pool_};
  const MappingStore mappings_{pool_};
  const BlobStore blobs_{pool_};
  const FeatureStore features_{pool_};
  const MapStore maps_{pool_};
  const RevisionStore revisions_{pool_};
  const RobotPoseStore robot_poses_{pool_};
  const LinkPointStore link_points_{pool_};
  const DoorVerdictStore verdicts_{pool_};
  const SiteLeaseStore leases_{pool_};
  const GraphStore graph_store_{pool_};
  const std::unique_ptr<server::Metrics> metrics_;
  const ClosureOptions options_;
  server::WakeSignal wake_;
  server::ChangedSites changed_;
  server::SiteGraphs graphs_{pool_, graph_store_, changed_};
  server::GraphOptimizer optimizer_{graph_store_, leases_, graphs_, changed_};
  std::optional<server::Mapping> mapping_;
  std::optional<server::DoorClosures> closures_;
};

class DoorClosuresTest : public StoreTest {
 protected:
  DoorClosuresTest() { Restart(); }

  void Restart() {
    workers_.reset();
    workers_ = std::make_unique<Workers>(*pool_, options_);
  }

  // A session into `map` or, without one, out of `previous`, with all its records; finished.
  SessionId Send(const DrivenSession& driven, const std::optional<MapId>& map,
                 const std::optional<SessionId>& previous) {
    Session session = MakeSession(site_, SessionId("s" + std::to_string(++sessions_made_)), robot_, map);
    session.entry.previous = previous;
    EXPECT_OK(sessions_.Create(Soon(), session, ""));
    for (const std::string& content : driven.contents) {
      const TestBlob blob(content);
      EXPECT_OK(blobs_.Put(Soon(), site_, {blob.view()}));
    }
    for (std::size_t i = 0; i < driven.log.size(); i += 500) {
      const std::size_t end = std::min(i + 500, driven.log.size());
      EXPECT_OK(Append(session.id, {driven.log.begin() + static_cast<std::ptrdiff_t>(i),
                                    driven.log.begin() + static_cast<std::ptrdiff_t>(end)}));
    }
    EXPECT_OK(sessions_.Finish(Soon(), site_, session.id, static_cast<std::int64_t>(driven.log.size())));
    return session.id;
  }

  std::vector<SessionId> SendAll(const std::vector<DrivenSession>& drive) {
    std::vector<SessionId> sessions;
    for (const DrivenSession& driven : drive) {
      sessions.push_back(sessions.empty() ? Send(driven, map_, {}) : Send(driven, {}, sessions.back()));
    }
    return sessions;
  }

  void AwaitMapped(const std::vector<SessionId>& sessions) {
    for (const SessionId& session : sessions) {
      for (int i = 0; i < 3000 && sessions_.Get(Soon(), site_, session)->state != SessionState::kMapped; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
      }
      ASSERT_EQ(sessions_.Get(Soon(), site_, session)->state, SessionState::kMapped) << session.value();
    }
    while (Value("SELECT count(*) FROM sessions WHERE door_reports > 0 AND NOT doors_judged") != "0") {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }
  std::vector<SessionId> MapAll(const std::vector<DrivenSession>& drive) {
    std::vector<SessionId> sessions = SendAll(drive);
    AwaitMapped(sessions);
    return sessions;
  }

  std::vector<DoorVerdict> Verdicts(const SessionId& session) {
    const auto verdicts = verdicts_.List(Soon(), site_, session, 0, 100);
    EXPECT_OK(verdicts);
    return *verdicts;
  }
  // In words, with the reasons on standard output for who looks into a failure.
  std::vector<std::string> Decisions(const std::vector<SessionId>& sessions) {
    std::vector<std::string> decisions;
    for (const SessionId& session : sessions) {
      for (const DoorVerdict& verdict : Verdicts(session)) {
        decisions.emplace_back(InWords(verdict.decision));
        std::cout << session.value() << ": " << decisions.back() << ": " << verdict.reason << "\n";
        for (const DoorComparison& compared : verdict.comparisons) std::cout << "    " << compared.reason << "\n";
      }
    }
    return decisions;
  }
  MapId MapOf(const SessionId& session) { return sessions_.Get(Soon(), site_, session)->map.value_or(MapId()); }

  static std::vector<std::string> DoorsOf(const std::vector<DrivenSession>& drive) {
    std::vector<std::string> doors;
    for (const DrivenSession& session : drive) doors.insert(doors.end(), session.doors.begin(), session.doors.end());
    return doors;
  }
  static DoorDriveOptions InTwoRooms() {
    DoorDriveOptions options = WithImagesAndClouds();
    options.campus = TwoRooms();
    options.robot = "r";
    return options;
  }
  // Driven once for all tests.
  static const std::vector<DrivenSession>& DriveInTwoRooms() {
    static const std::vector<DrivenSession> drive = DriveThroughDoors(InTwoRooms());
    return drive;
  }
  // The content of each image or cloud of the session becomes what `change` makes of it.
  static void Change(DrivenSession& session, const std::function<std::string(const Record&, std::string)>& change) {
    std::size_t next = 0;  // contents are in the order of the log
    for (Record& record : session.log) {
      BlobRef* content = nullptr;
      if (auto* image = std::get_if<Image>(&record.payload)) content = &image->content;
      if (auto* cloud = std::get_if<PointCloud>(&record.payload)) content = &cloud->content;
      if (content == nullptr) continue;
      std::string& bytes = session.contents[next++];
      bytes = change(record, std::move(bytes));
      *content = {Sha256(bytes), static_cast<std::int64_t>(bytes.size())};
    }
    ASSERT_GT(next, 10U);
  }

  std::string Value(const std::string& sql) { return database_.SqlValue(sql); }

  ClosureOptions options_;
  const DoorVerdictStore verdicts_{*pool_};
  std::unique_ptr<Workers> workers_;
  int sessions_made_ = 0;
};

TEST_F(DoorClosuresTest, TheCanonicalCampusIsMappedByItself) {
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
  // Optimisation has followed by itself.
  EXPECT_NE(Value("SELECT count(*) FROM graph_versions WHERE cause = 7"), "0");
}

TEST_F(DoorClosuresTest, TheRobotComesBackByACandidateAndGoesThroughAKnownDoorAgain) {
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

TEST_F(DoorClosuresTest, WithoutImagesAndCloudsTheVerdictSaysWhatWasMissing) {
  DoorDriveOptions options = InTwoRooms();
  options.simulation.image_hz = 0.0;
  options.simulation.cloud_hz = 0.0;
  const std::vector<DrivenSession> drive = DriveThroughDoors(options);
  const std::vector<SessionId> sessions = MapAll(drive);
  ASSERT_THAT(Decisions(sessions),
              ElementsAre("candidate made", "link point made", "link point made", "link point made"));
  EXPECT_THAT(Verdicts(sessions[0])[0].reason, HasSubstr("neither images nor clouds"));
  const std::vector<DoorVerdict> second = Verdicts(sessions[1]);
  ASSERT_THAT(second[0].comparisons, SizeIs(2));  // the candidate, and the door that it came by before
  EXPECT_THAT(second[0].comparisons[0].reason, HasSubstr("the robot has no images behind the door"));
  EXPECT_EQ(second[0].comparisons[0].image_matches, std::nullopt);
  EXPECT_EQ(second[0].comparisons[0].rmse, std::nullopt);
}

TEST_F(DoorClosuresTest, DamagedImagesAndCloudsCountAsMissing) {
  std::vector<DrivenSession> drive = DriveInTwoRooms();
  Change(drive[0], [](const Record& record, std::string bytes) {
    return bytes.substr(0, 101) + std::to_string(record.sequence);
  });
  const std::vector<SessionId> sessions = MapAll(drive);
  ASSERT_THAT(Decisions(sessions),
              ElementsAre("candidate made", "link point made", "link point made", "link point made"));
  const DoorVerdict verdict = Verdicts(sessions[1])[0];
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
  Change(drive[0], [&](const Record& record, std::string bytes) {
    return std::holds_alternative<Image>(record.payload) ? png : bytes;
  });
  drive.resize(2);
  const std::vector<SessionId> sessions = MapAll(drive);
  Decisions(sessions);
  const DoorVerdict verdict = Verdicts(sessions[1])[0];
  EXPECT_THAT(verdict.reason, HasSubstr("an image shows nothing: 0 features"));
  for (const DoorComparison& compared : verdict.comparisons) EXPECT_EQ(compared.image_matches, std::nullopt);
}

TEST_F(DoorClosuresTest, TheCloudOfAnotherPlaceIsNotBelievedWhateverTheImagesSay) {
  std::vector<DrivenSession> drive = DriveInTwoRooms();
  std::string other;
  Change(drive[1], [&](const Record& record, std::string bytes) {
    if (std::holds_alternative<PointCloud>(record.payload) && other.empty()) other = bytes;
    return bytes;
  });
  Change(drive[0], [&](const Record& record, std::string bytes) {
    return std::holds_alternative<PointCloud>(record.payload) ? other : bytes;
  });
  drive.resize(2);
  const std::vector<SessionId> sessions = MapAll(drive);
  ASSERT_THAT(Decisions(sessions), ElementsAre("candidate made", "link point made", "link point made"));
  const DoorVerdict verdict = Verdicts(sessions[1])[0];
  bool images_agreed = false;
  for (const DoorComparison& compared : verdict.comparisons) {
    images_agreed = images_agreed || compared.images_agree;
    EXPECT_FALSE(compared.accepted) << compared.reason;
  }
  EXPECT_TRUE(images_agreed);
}

TEST_F(DoorClosuresTest, SessionsAfterNoPassageBeginAMapThatNothingJoins) {
  const std::vector<SessionId> sessions = MapAll(std::vector<DrivenSession>(2));
  EXPECT_NE(MapOf(sessions[1]), map_);
  EXPECT_EQ(Value("SELECT count(*) FROM link_points"), "0");
  EXPECT_EQ(Value("SELECT initial_x IS NULL FROM sessions WHERE session_id = 's2'"), "t");
}

TEST_F(DoorClosuresTest, APassageAtWhichNothingWasMappedCannotBeJudged) {
  DoorReport report;
  report.time = report.door_time = 9;
  report.kind = DoorReport::Kind::kPassage;
  report.entered_level = 3;
  std::vector<DrivenSession> drive(2);
  drive[0].log = {{1, report}};
  const std::vector<SessionId> sessions = MapAll(drive);
  ASSERT_THAT(Decisions(sessions), ElementsAre("not judged"));
  EXPECT_THAT(Verdicts(sessions[0])[0].reason, HasSubstr("nothing was mapped"));
  EXPECT_EQ(Value("SELECT level FROM maps WHERE display_name = 'Map 1'"), "3");
  EXPECT_EQ(Value("SELECT count(*) FROM link_points"), "0");
}

TEST_F(DoorClosuresTest, WorkersThatEndInBetweenLeaveNothingHalf) {
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

// Where everything looks the same only the way there tells one door from another.
TEST_F(DoorClosuresTest, RoomsThatLookAlikeAreNotTakenForOneAnother) {
  DoorDriveOptions options = WithImagesAndClouds();
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

}  // namespace
}  // namespace enfilade::testing
