// SPDX-License-Identifier: Apache-2.0
#include <set>

#include "core/base/sha256.h"
#include "gmock/gmock.h"
#include "proto/convert/record.h"
#include "tests/rpc/server_test.h"
#include "tests/support/door_drive.h"

namespace enfilade::testing {
namespace {

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
    for (const sensor::Record& record : driven.log) {
      batch.push_back(convert::ToProto(record));
      if (batch.size() < 200 && &record != &driven.log.back()) continue;
      ASSERT_TRUE(stream.SendBatch(batch));
      batch.clear();
    }
    ASSERT_TRUE(stream.AwaitAcknowledged(driven.log.back().sequence));
  }
};

TEST_F(ClosureTest, TheRobotHearsOnItsStreamWhichMapItHasEntered) {
  DoorDriveOptions options;
  options.campus = TwoRooms();
  options.robot = "r";
  const std::vector<DrivenSession> drive = DriveThroughDoors(options);
  const std::string first = NewSession("sites/s/maps/m", "");
  const std::string second = NewSession("", first);
  TestStream waiting(*connection_, second);
  ASSERT_TRUE(waiting.Receive().has_opened());
  Send(first, drive[0]);
  ASSERT_OK(FinishSession(first, static_cast<std::int64_t>(drive[0].log.size())));
  const v1::StreamRecordsResponse told = waiting.Receive();
  ASSERT_TRUE(told.has_map_entered());
  EXPECT_EQ(told.map_entered().map(), GetSession(second).map());
  EXPECT_EQ(told.map_entered().map_display_name(), "Map 1");
  EXPECT_EQ(told.map_entered().verdict().decision(), v1::DoorVerdict::DECISION_LINK_POINT_MADE);
  EXPECT_EQ(told.map_entered().pose_map_robot().covariance_size(), 9);
  EXPECT_TRUE(told.map_entered().has_pose_odom_robot());
  // Also one that comes later, and one that was put there.
  TestStream later(*connection_, second);
  ASSERT_TRUE(later.Receive().has_opened());
  EXPECT_EQ(later.Receive().map_entered().map(), told.map_entered().map());

  v1::ListDoorVerdictsRequest list;
  list.set_parent(first);
  list.set_page_size(1);
  ASSERT_OK_AND_ASSIGN(auto page, Call(&v1::SessionService::Stub::ListDoorVerdicts, list));
  ASSERT_EQ(page.verdicts_size(), 1);
  EXPECT_EQ(page.verdicts(0).decision(), v1::DoorVerdict::DECISION_CANDIDATE_MADE);
  list.set_page_token(page.next_page_token());
  ASSERT_OK_AND_ASSIGN(page, Call(&v1::SessionService::Stub::ListDoorVerdicts, list));
  EXPECT_EQ(page.verdicts(0).entered_map(), told.map_entered().map());
  EXPECT_EQ(page.next_page_token(), "");

  // What the robot saw of the second door: images that it has sent, each once.
  v1::GetDoorImagesRequest images;
  images.set_name(page.verdicts(0).name());
  ASSERT_OK_AND_ASSIGN(const auto behind, Call(&v1::SessionService::Stub::GetDoorImages, images));
  std::set<std::string> sent, seen;
  for (const std::string& content : drive[0].contents) sent.insert(Sha256(content));
  for (const v1::Image& image : behind.seen()) {
    EXPECT_TRUE(sent.contains(image.content().sha256()));
    EXPECT_TRUE(seen.insert(image.content().sha256()).second);
    EXPECT_NE(image.encoding(), v1::Image::ENCODING_DEPTH_PNG16);
  }
  EXPECT_FALSE(seen.empty());
  ASSERT_EQ(behind.kept_size(), page.verdicts(0).comparisons_size());
  for (int i = 0; i < behind.kept_size(); ++i) {
    EXPECT_EQ(behind.kept(i).link_point(), page.verdicts(0).comparisons(i).link_point());
    EXPECT_FALSE(behind.kept(i).images().empty());
  }
  images.set_name(first + "/doors/1");
  EXPECT_CODE(Call(&v1::SessionService::Stub::GetDoorImages, images), absl::StatusCode::kNotFound);
  list.set_parent("sites/s/sessions/none");
  list.clear_page_token();
  EXPECT_CODE(Call(&v1::SessionService::Stub::ListDoorVerdicts, list), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace enfilade::testing
