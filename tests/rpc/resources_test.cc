// SPDX-License-Identifier: Apache-2.0
#include "tests/rpc/server_test.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;

class ResourcesTest : public ServerTest {
 protected:
  absl::StatusOr<v1::CreateMapResponse> CreateMap(const std::string& display_name, const std::string& request_id = "") {
    v1::CreateMapRequest request;
    request.set_parent("sites/s");
    request.mutable_map()->set_display_name(display_name);
    request.set_request_id(request_id);
    return Call(&v1::MapService::Stub::CreateMap, request);
  }
};

TEST_F(ResourcesTest, NamesHoldAnyCharacters) {
  for (const char* name :
       {"Robert'); DROP TABLE maps; --", "a/b\\c \"quoted\"", "Größe 楼层 🚪", "tab\tnew\nline", "%s %n"}) {
    ASSERT_OK(CreateMap(name));
    v1::ListMapsRequest request;
    request.set_parent("sites/s");
    request.set_display_name(name);
    ASSERT_OK_AND_ASSIGN(const v1::ListMapsResponse found, Call(&v1::MapService::Stub::ListMaps, request));
    ASSERT_EQ(found.maps_size(), 1) << name;
    EXPECT_EQ(found.maps(0).display_name(), name);
  }
  EXPECT_STATUS(CreateMap(""), absl::StatusCode::kInvalidArgument, HasSubstr("map.display_name"));
  EXPECT_CODE(CreateMap(std::string("a\0b", 3)), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(CreateMap(std::string(201, 'x')), absl::StatusCode::kInvalidArgument);
}

TEST_F(ResourcesTest, CreatingIsSafeToRepeatWithTheSameRequestId) {
  const std::string request_id = "7c9e6679-7425-40de-944b-e07fc1f90ae7";
  ASSERT_OK_AND_ASSIGN(const v1::CreateMapResponse first, CreateMap("Hall", request_id));
  ASSERT_OK_AND_ASSIGN(const v1::CreateMapResponse again, CreateMap("Hall", request_id));
  EXPECT_EQ(first.map().name(), again.map().name());
  EXPECT_CODE(CreateMap("Hall"), absl::StatusCode::kAlreadyExists);
}

TEST_F(ResourcesTest, ARequestIdIsShortAndForOneRequest) {
  ASSERT_OK(CreateMap("Hall", "request"));
  EXPECT_STATUS(CreateMap("Lab", "request"), absl::StatusCode::kInvalidArgument, HasSubstr("request_id"));
  EXPECT_OK(CreateMap("Lab", std::string(128, 'x')));
  EXPECT_STATUS(CreateMap("Yard", std::string(129, 'x')), absl::StatusCode::kInvalidArgument, HasSubstr("request_id"));
  v1::CreateRobotRequest robot;
  robot.set_parent("sites/s");
  robot.mutable_robot()->set_display_name("Robot 2");
  robot.set_request_id(std::string(100'000, 'x'));
  EXPECT_CODE(Call(&v1::RobotService::Stub::CreateRobot, robot), absl::StatusCode::kInvalidArgument);
}

TEST_F(ResourcesTest, UpdatesOnlyWhatTheMaskNamesAndOnlyWithTheLatestEtag) {
  v1::UpdateMapRequest request;
  request.mutable_map()->set_name("sites/s/maps/m");
  request.mutable_map()->set_display_name("New name");
  request.mutable_map()->set_level(0);
  request.mutable_update_mask()->add_paths("display_name");
  ASSERT_OK_AND_ASSIGN(const v1::UpdateMapResponse updated, Call(&v1::MapService::Stub::UpdateMap, request));
  EXPECT_EQ(updated.map().display_name(), "New name");

  request.mutable_map()->set_etag(updated.map().etag());
  request.mutable_map()->set_display_name("Newer name");
  ASSERT_OK(Call(&v1::MapService::Stub::UpdateMap, request));
  EXPECT_CODE(Call(&v1::MapService::Stub::UpdateMap, request), absl::StatusCode::kAborted) << "stale etag";
  request.mutable_update_mask()->add_paths("latest_revision");
  EXPECT_STATUS(Call(&v1::MapService::Stub::UpdateMap, request), absl::StatusCode::kInvalidArgument,
                HasSubstr("latest_revision"));
}

TEST_F(ResourcesTest, ASiteSaysHowLongItKeepsThings) {
  v1::UpdateSiteRequest request;
  v1::Site& site = *request.mutable_site();
  site.set_name("sites/s");
  site.mutable_revision_retention()->set_newest(5);
  site.mutable_revision_retention()->mutable_age()->set_seconds(86'400);
  site.mutable_audit_retention()->set_seconds(3'600);
  site.mutable_history_retention()->set_seconds(7'200);
  ASSERT_OK(Call(&v1::SiteService::Stub::UpdateSite, request));
  request.mutable_update_mask()->add_paths("revision_retention");
  request.mutable_update_mask()->add_paths("history_retention");
  site.mutable_revision_retention()->clear_age();
  site.clear_history_retention();
  site.clear_audit_retention();  // not in the mask
  ASSERT_OK_AND_ASSIGN(const v1::UpdateSiteResponse updated, Call(&v1::SiteService::Stub::UpdateSite, request));
  EXPECT_EQ(updated.site().revision_retention().newest(), 5);
  EXPECT_FALSE(updated.site().revision_retention().has_age());
  EXPECT_FALSE(updated.site().has_history_retention());
  EXPECT_EQ(updated.site().audit_retention().seconds(), 3'600);
  EXPECT_FALSE(updated.site().display_name().empty());
  for (const int newest : {0, -1, 1'000'001}) {
    site.mutable_revision_retention()->set_newest(newest);
    EXPECT_STATUS(Call(&v1::SiteService::Stub::UpdateSite, request), absl::StatusCode::kInvalidArgument,
                  HasSubstr("site.revision_retention.newest"));
  }
  site.mutable_revision_retention()->set_newest(1);
  site.mutable_revision_retention()->mutable_age()->set_seconds(-1);
  EXPECT_STATUS(Call(&v1::SiteService::Stub::UpdateSite, request), absl::StatusCode::kInvalidArgument,
                HasSubstr("site.revision_retention.age"));
}

TEST_F(ResourcesTest, PagesGoThroughEverythingOnce) {
  for (int i = 0; i < 25; ++i) ASSERT_OK(CreateMap("Map " + std::to_string(i)));
  v1::ListMapsRequest request;
  request.set_parent("sites/s");
  request.set_page_size(7);
  std::set<std::string> names;
  int pages = 0;
  do {
    ASSERT_OK_AND_ASSIGN(const v1::ListMapsResponse page, Call(&v1::MapService::Stub::ListMaps, request));
    EXPECT_LE(page.maps_size(), 7);
    for (const v1::Map& map : page.maps()) EXPECT_TRUE(names.insert(map.name()).second);
    request.set_page_token(page.next_page_token());
    ++pages;
  } while (!request.page_token().empty());
  EXPECT_EQ(names.size(), 26U);
  EXPECT_EQ(pages, 4);
  request.set_page_token("garbage");
  EXPECT_STATUS(Call(&v1::MapService::Stub::ListMaps, request), absl::StatusCode::kInvalidArgument,
                HasSubstr("page_token"));
  request.clear_page_token();
  request.set_page_size(-1);
  EXPECT_CODE(Call(&v1::MapService::Stub::ListMaps, request), absl::StatusCode::kInvalidArgument);
}

TEST_F(ResourcesTest, SessionsPageFromTheNewest) {
  std::vector<std::string> created;
  for (int i = 0; i < 5; ++i) created.push_back(CreateSession(false));
  v1::ListSessionsRequest request;
  request.set_parent("sites/s");
  request.set_page_size(2);
  std::vector<std::string> listed;
  do {
    ASSERT_OK_AND_ASSIGN(const v1::ListSessionsResponse page, Call(&v1::SessionService::Stub::ListSessions, request));
    for (const v1::Session& session : page.sessions()) listed.push_back(session.name());
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty());
  EXPECT_EQ(listed, std::vector<std::string>(created.rbegin(), created.rend()));
}

TEST_F(ResourcesTest, DeletionReportsWhatDependsAndForceRemovesIt) {
  CreateSession(true);
  v1::DeleteMapRequest request;
  request.set_name("sites/s/maps/m");
  EXPECT_CODE(Call(&v1::MapService::Stub::DeleteMap, request), absl::StatusCode::kFailedPrecondition);
  request.set_force(true);
  EXPECT_OK(Call(&v1::MapService::Stub::DeleteMap, request));
  v1::GetMapRequest get;
  get.set_name("sites/s/maps/m");
  EXPECT_CODE(Call(&v1::MapService::Stub::GetMap, get), absl::StatusCode::kNotFound);

  v1::DeleteSiteRequest site;
  site.set_name("sites/s");
  EXPECT_CODE(Call(&v1::SiteService::Stub::DeleteSite, site), absl::StatusCode::kFailedPrecondition);
  site.set_force(true);
  EXPECT_OK(Call(&v1::SiteService::Stub::DeleteSite, site));
}

TEST_F(ResourcesTest, SitesAreKeptApart) {
  v1::CreateSiteRequest site;
  site.set_site_id("other");
  site.mutable_site()->set_display_name("Other");
  ASSERT_OK(Call(&v1::SiteService::Stub::CreateSite, site));
  v1::CreateSessionRequest request;
  request.set_parent("sites/other");
  request.mutable_session()->set_robot("sites/s/robots/r");
  EXPECT_STATUS(Call(&v1::SessionService::Stub::CreateSession, request), absl::StatusCode::kInvalidArgument,
                HasSubstr("session.robot"));
  request.mutable_session()->set_robot("sites/other/robots/r");
  EXPECT_CODE(Call(&v1::SessionService::Stub::CreateSession, request), absl::StatusCode::kNotFound);
}

TEST_F(ResourcesTest, FinishingNeedsTheWholeLog) {
  const std::string session = CreateSession(false);
  TestStream stream(*connection_, session);
  stream.SendBatch(ScanRecords(1, 5));
  ASSERT_TRUE(stream.AwaitAcknowledged(5));
  EXPECT_CODE(FinishSession(session, 7), absl::StatusCode::kFailedPrecondition);
  EXPECT_OK(FinishSession(session, 5));
  EXPECT_OK(FinishSession(session, 5)) << "may be repeated";
  EXPECT_EQ(GetSession(session).state(), v1::Session::STATE_MAPPED) << "there is no map to make";
}

}  // namespace
}  // namespace enfilade::testing
