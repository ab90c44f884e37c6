// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <thread>

#include "core/base/sha256.h"
#include "core/geometry/pose2.h"
#include "fmt/format.h"
#include "tests/rpc/link_point_fixture.h"
#include "tests/support/pose_matchers.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Stub = v1::LinkPointService::Stub;

Pose2 ToPose(const v1::Pose2& pose) { return {pose.x(), pose.y(), pose.yaw()}; }

// map_manager's canonical scenario (reference 1.7): four maps around a loop, five link points, the candidates LC0 and
// LC1 waiting for the closures L3 and L4; with ids that are not consecutive.
TEST_F(LinkPointTest, TheCanonicalScenarioGivesFiveLinkPointsAndEightEdges) {
  const std::vector<std::string> maps = {"m", "m77", "m5", "m130"};
  const std::vector<Pose2> T_world_map = {{}, {10, 2, 0.5}, {14, 12, 1.7}, {3, 15, -2.0}};
  for (std::size_t i = 1; i < maps.size(); ++i) CreateMap(maps[i], 0);
  const auto anchor = [&](std::size_t map, const Pose2& T_world_place) {
    return MakeAnchor(maps[map], Inverse(T_world_map[map]) * T_world_place);
  };
  const Pose2 l0{9, 1, 0.1}, l1{13, 8, 1.0}, l2{8, 14, 2.5}, l3{1, 12, -1.5}, l4{12, 11, 0.7};
  ASSERT_OK(Create("l3", {anchor(0, l3)}));  // LC0
  ASSERT_OK(Create("l0", {anchor(0, l0), anchor(1, l0)}));
  ASSERT_OK(Create("l1", {anchor(1, l1), anchor(2, l1)}));
  ASSERT_OK(Create("l4", {anchor(2, l4)}));  // LC1
  ASSERT_OK(Create("l2", {anchor(2, l2), anchor(3, l2)}));
  v1::ListLinkPointsRequest candidates;
  candidates.set_parent("sites/s");
  candidates.set_subset(v1::LINK_POINT_SUBSET_CANDIDATES);
  ASSERT_OK_AND_ASSIGN(const auto waiting, Call(&Stub::ListLinkPoints, candidates));
  EXPECT_EQ(waiting.link_points_size(), 2);
  ASSERT_OK(AddAnchor("l3", anchor(3, l3)));
  ASSERT_OK(AddAnchor("l4", anchor(0, l4)));

  std::map<std::string, v1::LinkPoint> all;
  v1::ListLinkPointsRequest request;
  request.set_parent("sites/s");
  ASSERT_OK_AND_ASSIGN(const auto listed, Call(&Stub::ListLinkPoints, request));
  for (const auto& link_point : listed.link_points()) all[link_point.name()] = link_point;
  EXPECT_EQ(all.size(), 5U);
  int edges = 0;
  for (const std::string& map : maps) {
    request.set_map("sites/s/maps/" + map);
    ASSERT_OK_AND_ASSIGN(const auto in_map, Call(&Stub::ListLinkPoints, request));
    edges += in_map.link_points_size() * (in_map.link_points_size() - 1) / 2;
  }
  EXPECT_EQ(edges, 8);

  // Around the loop: exact poses compose to the identity.
  const auto between = [&](const std::string& id, std::size_t from, std::size_t to) {
    Pose2 T_from, T_to;
    for (const auto& seen : all.at("sites/s/linkPoints/" + id).anchors()) {
      if (seen.map() == "sites/s/maps/" + maps[from]) T_from = ToPose(seen.pose_map_place().pose());
      if (seen.map() == "sites/s/maps/" + maps[to]) T_to = ToPose(seen.pose_map_place().pose());
    }
    return T_from * Inverse(T_to);
  };
  EXPECT_THAT(between("l0", 0, 1) * between("l1", 1, 2) * between("l2", 2, 3) * between("l3", 3, 0),
              PoseNear(Pose2{}, 1e-9, 1e-9));
  EXPECT_THAT(between("l0", 0, 1) * between("l1", 1, 2) * between("l4", 2, 0), PoseNear(Pose2{}, 1e-9, 1e-9));
  EXPECT_THAT(ToPose(all.at("sites/s/linkPoints/l2").pose_world_place().pose()), PoseNear(l2, 1e-9, 1e-9));
  EXPECT_STATUS(Create("again", {anchor(0, l4), anchor(2, l4)}), absl::StatusCode::kAlreadyExists,
                HasSubstr("linkPoints/l4"));
}

TEST_F(LinkPointTest, TagsHoldAnyCharacters) {
  int i = 0;
  for (const char* tag : {"O'Neil \"x\"", "a/b\\c", "'); DROP TABLE link_points; --", "Tür 楼 🚪", "tab\tnew\nline"}) {
    auto request = MakeRequest("p" + std::to_string(i), {MakeAnchor("m", {5.0 * i, 0, 0})});
    request.mutable_link_point()->set_tag(tag);
    ASSERT_OK(Call(&Stub::CreateLinkPoint, request));
    v1::ListLinkPointsRequest list;
    list.set_parent("sites/s");
    list.set_tag(tag);
    ASSERT_OK_AND_ASSIGN(const auto listed, Call(&Stub::ListLinkPoints, list));
    ASSERT_EQ(listed.link_points_size(), 1) << tag;
    EXPECT_EQ(listed.link_points(0).tag(), tag);
    ++i;
  }
  auto request = MakeRequest("long", {MakeAnchor("m", {})});
  request.mutable_link_point()->set_tag(std::string(201, 'x'));
  EXPECT_STATUS(Call(&Stub::CreateLinkPoint, request), absl::StatusCode::kInvalidArgument, HasSubstr("tag"));
}

TEST_F(LinkPointTest, UpdatesOnlyWhatTheMaskNamesAndOnlyWithTheLatestEtag) {
  ASSERT_OK_AND_ASSIGN(const v1::LinkPoint door, Create("door", {MakeAnchor("m", {1, 2, 0}), MakeAnchor("lab", {})}));
  EXPECT_EQ(door.kind(), v1::LinkPoint::KIND_DOOR);
  EXPECT_EQ(door.anchors(0).pose_map_place().covariance(0), 0.0015);
  v1::UpdateLinkPointRequest request;
  request.mutable_link_point()->set_name(door.name());
  request.mutable_link_point()->set_etag(door.etag());
  request.mutable_link_point()->set_tag("not named");
  request.mutable_link_point()->set_state(v1::LinkPoint::STATE_BLOCKED);
  request.mutable_link_point()->mutable_state_valid_until()->set_seconds(1'900'000'000);
  request.mutable_update_mask()->add_paths("state");
  request.mutable_update_mask()->add_paths("state_valid_until");
  ASSERT_OK_AND_ASSIGN(const auto updated, Call(&Stub::UpdateLinkPoint, request));
  EXPECT_EQ(updated.link_point().state(), v1::LinkPoint::STATE_BLOCKED);
  EXPECT_EQ(updated.link_point().state_valid_until().seconds(), 1'900'000'000);
  EXPECT_EQ(updated.link_point().tag(), "");
  EXPECT_EQ(updated.link_point().anchors_size(), 2);
  EXPECT_GT(updated.link_point().graph_version(), door.graph_version());
  EXPECT_CODE(Call(&Stub::UpdateLinkPoint, request), absl::StatusCode::kAborted);
  request.mutable_update_mask()->add_paths("use");
  EXPECT_STATUS(Call(&Stub::UpdateLinkPoint, request), absl::StatusCode::kInvalidArgument, HasSubstr("use"));

  v1::SuspendLinkPointRequest suspend;
  suspend.set_name(door.name());
  ASSERT_OK_AND_ASSIGN(const auto suspended, Call(&Stub::SuspendLinkPoint, suspend));
  EXPECT_EQ(suspended.link_point().use(), v1::LinkPoint::USE_SUSPENDED);
  v1::ResumeLinkPointRequest resume;
  resume.set_name(door.name());
  resume.set_etag(updated.link_point().etag());
  EXPECT_CODE(Call(&Stub::ResumeLinkPoint, resume), absl::StatusCode::kAborted);
  resume.clear_etag();
  EXPECT_OK(Call(&Stub::ResumeLinkPoint, resume));
  v1::DeleteLinkPointRequest remove;
  remove.set_name(door.name());
  EXPECT_OK(Call(&Stub::DeleteLinkPoint, remove));
  EXPECT_CODE(Call(&Stub::DeleteLinkPoint, remove), absl::StatusCode::kNotFound);
}

TEST_F(LinkPointTest, RefusesWhatItDoesNotUnderstand) {
  auto request = MakeRequest("p", {MakeAnchor("m", {})});
  request.mutable_link_point()->set_kind(static_cast<v1::LinkPoint::Kind>(99));
  EXPECT_STATUS(Call(&Stub::CreateLinkPoint, request), absl::StatusCode::kInvalidArgument, HasSubstr("kind"));
  request = MakeRequest("p", {MakeAnchor("m", {std::nan(""), 0, 0})});
  EXPECT_STATUS(Call(&Stub::CreateLinkPoint, request), absl::StatusCode::kInvalidArgument, HasSubstr("anchors[0]"));
  request = MakeRequest("p", {MakeAnchor("m", {})});
  request.mutable_link_point()->mutable_anchors(0)->set_map("sites/other/maps/m");
  EXPECT_STATUS(Call(&Stub::CreateLinkPoint, request), absl::StatusCode::kInvalidArgument, HasSubstr("site"));
  request = MakeRequest("No valid id", {MakeAnchor("m", {})});
  EXPECT_CODE(Call(&Stub::CreateLinkPoint, request), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(Create("p", {MakeAnchor("cellar", {})}), absl::StatusCode::kNotFound);
  v1::FindLinkPointsRequest find;
  find.set_parent("sites/s");
  EXPECT_STATUS(Call(&Stub::FindLinkPoints, find), absl::StatusCode::kInvalidArgument, HasSubstr("no place to search"));
  find.mutable_point_world();
  find.set_subset(static_cast<v1::LinkPointSubset>(7));
  EXPECT_STATUS(Call(&Stub::FindLinkPoints, find), absl::StatusCode::kInvalidArgument, HasSubstr("subset"));
  const auto refuses_empty = [&](auto method, auto empty) {
    EXPECT_CODE(Call(method, empty), absl::StatusCode::kInvalidArgument) << empty.GetTypeName();
  };
  refuses_empty(&Stub::CreateLinkPoint, v1::CreateLinkPointRequest());
  refuses_empty(&Stub::AddLinkPointAnchor, v1::AddLinkPointAnchorRequest());
  refuses_empty(&Stub::GetLinkPoint, v1::GetLinkPointRequest());
  refuses_empty(&Stub::ListLinkPoints, v1::ListLinkPointsRequest());
  refuses_empty(&Stub::UpdateLinkPoint, v1::UpdateLinkPointRequest());
  refuses_empty(&Stub::DeleteLinkPoint, v1::DeleteLinkPointRequest());
  refuses_empty(&Stub::SuspendLinkPoint, v1::SuspendLinkPointRequest());
  refuses_empty(&Stub::ResumeLinkPoint, v1::ResumeLinkPointRequest());
  refuses_empty(&Stub::FindLinkPoints, v1::FindLinkPointsRequest());
  EXPECT_CODE(Attach("", v1::Evidence(), ""), absl::StatusCode::kInvalidArgument);
}

TEST_F(LinkPointTest, PagesGoThroughEverythingOnce) {
  for (int i = 0; i < 25; ++i) ASSERT_OK(Create(fmt::format("p{}", i), {MakeAnchor("m", {3.0 * i, 0, 0})}));
  v1::ListLinkPointsRequest request;
  request.set_parent("sites/s");
  request.set_page_size(7);
  std::set<std::string> names;
  int pages = 0;
  do {
    ASSERT_OK_AND_ASSIGN(const auto page, Call(&Stub::ListLinkPoints, request));
    for (const auto& link_point : page.link_points()) EXPECT_TRUE(names.insert(link_point.name()).second);
    request.set_page_token(page.next_page_token());
    ++pages;
  } while (!request.page_token().empty());
  EXPECT_EQ(names.size(), 25U);
  EXPECT_EQ(pages, 4);
}

TEST_F(LinkPointTest, EvidenceComesInChunksOrByWhatIsStoredAlready) {
  ASSERT_OK(Create("door", {MakeAnchor("m", {}), MakeAnchor("lab", {})}));
  const std::string bytes(300'000, 'x');
  v1::Evidence evidence;
  evidence.set_map("sites/s/maps/m");
  v1::Image& image = *evidence.mutable_image();
  image.mutable_time()->set_seconds(1'700'000'000);
  image.set_camera(v1::Image::CAMERA_REAR);
  image.set_encoding(v1::Image::ENCODING_PNG);
  image.mutable_content()->set_sha256(Sha256(bytes));
  image.mutable_content()->set_size_bytes(static_cast<std::int64_t>(bytes.size()));
  EXPECT_STATUS(Attach("door", evidence, ""), absl::StatusCode::kInvalidArgument, HasSubstr("send it"));
  EXPECT_OK(Attach("door", evidence, bytes));
  evidence.set_map("sites/s/maps/lab");
  EXPECT_OK(Attach("door", evidence, ""));
  EXPECT_CODE(Attach("gate", evidence, ""), absl::StatusCode::kNotFound);
  v1::GetLinkPointRequest get;
  get.set_name("sites/s/linkPoints/door");
  ASSERT_OK_AND_ASSIGN(const auto door, Call(&Stub::GetLinkPoint, get));
  ASSERT_EQ(door.link_point().evidence_size(), 2);
  EXPECT_EQ(door.link_point().evidence(0).SerializeAsString(), evidence.SerializeAsString());
}

TEST_F(LinkPointTest, TheAuditTrailNamesTheActor) {
  const auto stub = v1::LinkPointService::NewStub(connection_->channel());
  grpc::ClientContext context;
  context.AddMetadata("enfilade-actor", "ann@example.org");
  v1::CreateLinkPointResponse response;
  ASSERT_OK(
      client::FromGrpcStatus(stub->CreateLinkPoint(&context, MakeRequest("door", {MakeAnchor("m", {})}), &response)));
  ASSERT_OK(Create("door-2", {MakeAnchor("lab", {})}));
  v1::ListAuditEntriesRequest request;
  request.set_parent("sites/s");
  request.set_resource("sites/s/linkPoints/door");
  request.set_page_size(1);
  std::vector<std::string> resources;
  do {
    ASSERT_OK_AND_ASSIGN(const auto page, Call(&v1::SiteService::Stub::ListAuditEntries, request));
    ASSERT_EQ(page.entries_size(), 1);
    const v1::AuditEntry& entry = page.entries(0);
    resources.push_back(entry.resource());
    EXPECT_EQ(entry.actor(), "ann@example.org");
    EXPECT_EQ(entry.action(), v1::AuditEntry::ACTION_CREATED);
    EXPECT_EQ(entry.before(), "");
    EXPECT_THAT(entry.after(), HasSubstr("door"));
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty());
  EXPECT_THAT(resources, ElementsAre("sites/s/linkPoints/door/anchors/m", "sites/s/linkPoints/door"));
  request.set_resource("sites/other/maps/m");
  EXPECT_CODE(Call(&v1::SiteService::Stub::ListAuditEntries, request), absl::StatusCode::kInvalidArgument);
}

TEST_F(LinkPointTest, MapsHaveOutlinesThatAreKeptAndChecked) {
  v1::UpdateMapRequest request;
  request.mutable_map()->set_name("sites/s/maps/m");
  for (const auto& [x, y] : std::vector<std::pair<double, double>>{{0, 0}, {4, 0}, {4, 3}}) {
    v1::Point& corner = *request.mutable_map()->mutable_outline()->add_corners();
    corner.set_x(x);
    corner.set_y(y);
  }
  ASSERT_OK_AND_ASSIGN(const auto updated, Call(&v1::MapService::Stub::UpdateMap, request));
  EXPECT_EQ(updated.map().outline().SerializeAsString(), request.map().outline().SerializeAsString());
  request.mutable_map()->mutable_outline()->mutable_corners()->RemoveLast();
  EXPECT_STATUS(Call(&v1::MapService::Stub::UpdateMap, request), absl::StatusCode::kInvalidArgument,
                HasSubstr("outline"));
  request.mutable_map()->clear_outline();
  request.mutable_update_mask()->add_paths("outline");
  ASSERT_OK_AND_ASSIGN(const auto cleared, Call(&v1::MapService::Stub::UpdateMap, request));
  EXPECT_EQ(cleared.map().outline().corners_size(), 0);
}

TEST_F(LinkPointTest, RobotsReportPosesBesideTheirLog) {
  TestStream stream(*connection_, CreateSession(false));
  stream.Receive();
  v1::StreamRecordsRequest request;
  v1::PoseReport& report = *request.mutable_pose_report();
  report.set_map("sites/s/maps/m");
  report.mutable_time()->set_seconds(1'700'000'000);
  for (int i = 1; i <= 50; ++i) {
    report.mutable_time()->set_nanos(i);
    report.mutable_pose_map_robot()->mutable_pose()->set_x(i);
    ASSERT_TRUE(stream.Send(request));
  }
  ASSERT_TRUE(stream.SendBatch(ScanRecords(1, 3)));
  EXPECT_TRUE(stream.AwaitAcknowledged(3));
  // Whatever came between was taken or skipped: the last one is stored.
  std::string x;
  for (int i = 0; i < 3000 && x != "50"; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    x = database_.SqlValue("SELECT ST_X(point) FROM enfilade.robot_poses WHERE robot_id = 'r'");
  }
  EXPECT_EQ(x, "50");
  report.set_map("sites/s/maps/cellar");
  report.mutable_time()->set_nanos(99);
  ASSERT_TRUE(stream.Send(request));
  const auto refused = stream.Receive();
  EXPECT_THAT(refused.pose_report_refused().message(), HasSubstr("cellar"));
  report.set_map("nonsense");
  ASSERT_TRUE(stream.Send(request));
  EXPECT_THAT(stream.Receive().pose_report_refused().message(), HasSubstr("pose_report.map"));
  ASSERT_TRUE(stream.SendBatch(ScanRecords(4, 1)));
  EXPECT_TRUE(stream.AwaitAcknowledged(4));
  EXPECT_OK(stream.Finish());
  EXPECT_EQ(database_.SqlValue("SELECT ST_X(point) FROM enfilade.robot_poses WHERE robot_id = 'r'"), "50");
}

}  // namespace
}  // namespace enfilade::testing
