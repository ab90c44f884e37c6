#include <map>
#include <set>

#include "core/base/sha256.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "gmock/gmock.h"
#include "proto/convert/geometry.h"
#include "proto/convert/record.h"
#include "tests/rpc/door_drive.h"
#include "tests/rpc/server_test.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

std::string DecisionName(v1::DoorVerdict::Decision decision) {
  return v1::DoorVerdict::Decision_Name(decision).substr(std::string("DECISION_").size());
}

class ClosureTest : public ServerTest {
 protected:
  // A session of robot "r" into `map` ("" for one out of `previous`).
  std::string NewSession(const std::string& map, const std::string& previous) {
    v1::CreateSessionRequest request;
    request.set_parent("sites/s");
    request.mutable_session()->set_robot("sites/s/robots/r");
    if (!map.empty()) request.mutable_session()->set_map(map);
    if (!previous.empty()) request.mutable_session()->mutable_entry()->set_previous_session(previous);
    const auto created = Call(&v1::SessionService::Stub::CreateSession, request);
    EXPECT_OK(created);
    return created.ok() ? created->session().name() : "";
  }

  void Send(const std::string& session, const DrivenSession& driven) {
    TestStream stream(*connection_, session);
    for (const std::string& content : driven.contents) ASSERT_TRUE(stream.SendBlob(content, Sha256(content)));
    std::vector<v1::Record> batch;
    for (const Record& record : driven.log) {
      batch.push_back(ToProto(record));
      if (batch.size() < 200 && &record != &driven.log.back()) continue;
      ASSERT_TRUE(stream.SendBatch(batch));
      batch.clear();
    }
    ASSERT_TRUE(stream.AwaitAcknowledged(driven.log.back().sequence));
  }

  // Sends all, each session out of the one before, and waits until the last is mapped. Gives their names.
  std::vector<std::string> SendAll(const std::vector<DrivenSession>& drive, const std::string& map) {
    std::vector<std::string> names;
    for (const DrivenSession& driven : drive) {
      names.push_back(NewSession(names.empty() ? map : "", names.empty() ? "" : names.back()));
      if (!driven.log.empty()) Send(names.back(), driven);
      EXPECT_OK(FinishSession(names.back(), static_cast<std::int64_t>(driven.log.size())));
    }
    for (const std::string& name : names) AwaitState(name, v1::Session::STATE_MAPPED);
    return names;
  }

  std::vector<v1::DoorVerdict> Verdicts(const std::string& session) {
    v1::ListDoorVerdictsRequest request;
    request.set_parent(session);
    const auto response = Call(&v1::SessionService::Stub::ListDoorVerdicts, request);
    EXPECT_OK(response);
    return {response->verdicts().begin(), response->verdicts().end()};
  }

  std::vector<std::string> Decisions(const std::vector<std::string>& sessions) {
    std::vector<std::string> decisions;
    for (const std::string& session : sessions) {
      for (const v1::DoorVerdict& verdict : Verdicts(session)) {
        decisions.push_back(DecisionName(verdict.decision()));
        RecordProperty(verdict.name(), verdict.reason());
        std::cout << verdict.name() << ": " << DecisionName(verdict.decision()) << " " << verdict.reason() << "\n";
        for (const v1::DoorComparison& c : verdict.comparisons()) std::cout << "    " << c.reason() << "\n";
      }
    }
    return decisions;
  }

  std::string Value(const std::string& sql) { return database_.SqlValue(sql); }
};

TEST_F(ClosureTest, DoorsSeenAndPassedForTheFirstTimeMakeCandidatesLinkPointsAndMaps) {
  std::vector<DrivenSession> drive = DriveThroughDoors(WithImagesAndClouds());
  drive.resize(3);  // out of the hall, into the next one, and out of it
  const std::vector<std::string> sessions = SendAll(drive, "sites/s/maps/m");
  EXPECT_THAT(Decisions(sessions),
              ElementsAre("CANDIDATE_MADE", "LINK_POINT_MADE", "LINK_POINT_MADE", "CANDIDATE_MADE", "LINK_POINT_MADE"));
  EXPECT_EQ(Value("SELECT string_agg(display_name, ',' ORDER BY display_name) FROM maps WHERE map_id <> 'm'"),
            "Map 1,Map 2,Map 3");
  EXPECT_EQ(Value("SELECT count(*) FROM link_points WHERE anchor_count = 2"), "3");
  EXPECT_EQ(Value("SELECT count(*) FROM link_points WHERE anchor_count = 1"), "2");
  // Every place has a place in the world, and images and a cloud of every map that sees it.
  EXPECT_EQ(Value("SELECT count(*) FROM link_points WHERE position IS NULL"), "0");
  EXPECT_EQ(Value("SELECT count(*) FROM link_point_anchors a WHERE NOT EXISTS (SELECT FROM link_point_evidence e"
                  " WHERE e.link_point_id = a.link_point_id AND e.map_id = a.map_id AND e.kind = 2 AND e.x IS NOT NULL)"
                  " OR NOT EXISTS (SELECT FROM link_point_evidence e WHERE e.link_point_id = a.link_point_id"
                  " AND e.map_id = a.map_id AND e.kind = 3)"),
            "0");
  EXPECT_EQ(Value("SELECT count(*) FROM image_features") != "0", true) << "kept for the next comparison";
  EXPECT_NE(GetSession(sessions[1]).map(), GetSession(sessions[2]).map());
}

}  // namespace
}  // namespace enfilade::testing
