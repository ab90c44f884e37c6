// SPDX-License-Identifier: Apache-2.0
#include <set>

#include "core/base/sha256.h"
#include "gmock/gmock.h"
#include "proto/convert/record.h"
#include "tests/rpc/server_test.h"
#include "tests/support/door_drive.h"
#include "tests/support/eventually.h"

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
  list.set_parent("sites/s/sessions/none");
  list.clear_page_token();
  EXPECT_CODE(Call(&v1::SessionService::Stub::ListDoorVerdicts, list), absl::StatusCode::kNotFound);
}

TEST_F(ClosureTest, TheImagesBehindAVerdictAreWhatTheRobotSentAndWhatIsKept) {
  DoorDriveOptions options = WithImagesAndClouds();
  options.campus = TwoRooms();
  options.robot = "r";
  const std::vector<DrivenSession> drive = DriveThroughDoors(options);
  ASSERT_GE(drive.size(), 2U);
  std::string session = NewSession("sites/s/maps/m", "");
  const std::string first = session;
  std::set<std::string> sent;
  std::vector<v1::DoorVerdict> verdicts;
  v1::ListDoorVerdictsRequest list;
  for (int i = 0; i < 2; ++i) {
    if (i > 0) session = NewSession("", session);
    Send(session, drive[i]);
    for (const std::string& content : drive[i].contents) sent.insert(Sha256(content));
    ASSERT_OK(FinishSession(session, static_cast<std::int64_t>(drive[i].log.size())));
    list.set_parent(session);
    ASSERT_TRUE(Eventually([&] {
      const auto page = Call(&v1::SessionService::Stub::ListDoorVerdicts, list);
      return page.ok() && page->verdicts_size() == static_cast<int>(drive[i].doors.size());
    }));
    ASSERT_OK_AND_ASSIGN(const auto page, Call(&v1::SessionService::Stub::ListDoorVerdicts, list));
    verdicts.insert(verdicts.end(), page.verdicts().begin(), page.verdicts().end());
  }
  int kept_images = 0;
  v1::GetDoorImagesRequest request;
  for (const v1::DoorVerdict& verdict : verdicts) {
    request.set_name(verdict.name());
    ASSERT_OK_AND_ASSIGN(const auto images, Call(&v1::SessionService::Stub::GetDoorImages, request));
    std::set<std::string> seen;
    for (const v1::Image& image : images.seen()) {
      EXPECT_TRUE(sent.contains(image.content().sha256()));
      EXPECT_TRUE(seen.insert(image.content().sha256()).second);
      EXPECT_NE(image.encoding(), v1::Image::ENCODING_DEPTH_PNG16);
    }
    EXPECT_FALSE(seen.empty()) << verdict.ShortDebugString();
    ASSERT_EQ(images.kept_size(), verdict.comparisons_size());
    for (int i = 0; i < images.kept_size(); ++i) {
      EXPECT_EQ(images.kept(i).link_point(), verdict.comparisons(i).link_point());
      EXPECT_EQ(images.kept(i).map(), verdict.comparisons(i).map());
      for (const v1::Image& image : images.kept(i).images()) EXPECT_TRUE(sent.contains(image.content().sha256()));
      kept_images += images.kept(i).images_size();
    }
  }
  EXPECT_GT(kept_images, 0);
  request.set_name(first + "/doors/1");
  EXPECT_CODE(Call(&v1::SessionService::Stub::GetDoorImages, request), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace enfilade::testing
