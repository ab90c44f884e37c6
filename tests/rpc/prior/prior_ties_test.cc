// SPDX-License-Identifier: Apache-2.0
// What a plan in use does to the site's graph.
#include <chrono>
#include <cmath>
#include <thread>

#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "enfilade/v1/prior_map_service.grpc.pb.h"
#include "proto/convert/geometry.h"
#include "tests/rpc/prior/prior_map_fixture.h"
#include "tests/support/eventually.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Map "m" has the west of the building; map "n", which nothing joins to it, has the east.
class PriorTiesTest : public PriorMapFixture {
 protected:
  static bool IsEast(const Eigen::Vector2d& sheet) { return sheet.x() > 330; }
  // Where the plan lies in map "n".
  static Eigen::Vector2d InEast(const Eigen::Vector2d& sheet) {
    const double turn = -1.1;
    Eigen::Matrix2d rotation;
    rotation << std::cos(turn), -std::sin(turn), std::sin(turn), std::cos(turn);
    return 0.05 * rotation * Eigen::Vector2d(sheet.x(), -sheet.y()) + Eigen::Vector2d(12.0, 4.0);
  }
  void MapBoth() {
    MapBuilding(IsWest);
    MakeMap("n");
    MapBuilding(IsEast, "n", InEast);
  }
  v1::GlobalPose WhereIs(const std::string& map, const Eigen::Vector2d& point = Eigen::Vector2d::Zero()) const {
    v1::GetGlobalPoseRequest request;
    v1::MapPose& pose = *request.mutable_map_pose();
    pose.set_map("sites/s/maps/" + map);
    pose.mutable_pose_map_robot()->mutable_pose()->set_x(point.x());
    pose.mutable_pose_map_robot()->mutable_pose()->set_y(point.y());
    const auto response = Call(&v1::GraphService::Stub::GetGlobalPose, request);
    EXPECT_OK(response.status());
    return response.ok() ? response->global_pose() : v1::GlobalPose();
  }
  absl::StatusOr<v1::ListPriorAssociationsResponse> ListPage(int size, const std::string& token) const {
    v1::ListPriorAssociationsRequest request;
    request.set_parent(kPlan);
    request.set_page_size(size);
    request.set_page_token(token);
    return Call(&v1::PriorMapService::Stub::ListPriorAssociations, request);
  }
  std::vector<v1::PriorAssociation> ListAssociations() const {
    std::vector<v1::PriorAssociation> all;
    std::string token;
    do {
      const auto page = ListPage(10, token);
      EXPECT_OK(page.status());
      if (!page.ok()) break;
      EXPECT_LE(page->associations_size(), 10);
      all.insert(all.end(), page->associations().begin(), page->associations().end());
      token = page->next_page_token();
    } while (!token.empty());
    return all;
  }
  // A server that aligns plans in use again as soon as it may, and the plan, found in the west of the building.
  void AlignWestAndFollow() {
    server::ServerOptions options = Options();
    options.prior_maps.realign_s = 1.0;
    Restart(options);
    MapBuilding(IsWest);
    ASSERT_OK(ImportDrawnBuilding().status());
    ASSERT_OK(Align().status());
  }
  bool IsPlaced(const std::string& map) const { return WhereIs(map).has_pose_world_robot(); }
};

TEST_F(PriorTiesTest, APlanInUseIsAlignedAgainWhenRobotsHaveMappedMore) {
  AlignWestAndFollow();
  ASSERT_OK_AND_ASSIGN(const v1::PriorMap before, Activate());
  MapBuilding([](const Eigen::Vector2d&) { return true; });
  v1::PriorMap after;
  ASSERT_TRUE(Eventually([&] {
    after = Get();
    return after.alignment().tied_walls() > before.alignment().tied_walls();
  })) << after.DebugString();
  EXPECT_EQ(after.state(), v1::PriorMap::STATE_ACTIVE);
  EXPECT_EQ(after.reason(), before.reason());
  EXPECT_EQ(after.alignment().rival_ratio(), before.alignment().rival_ratio());
  for (const Eigen::Vector2d& sheet : {Eigen::Vector2d(10, 10), {860, 20}, {600, 400}}) {
    EXPECT_LT((Placed(after.alignment(), sheet) - Truth(sheet)).norm(), 0.1);
  }
  // Somewhere else robots have been does not fit it.
  MapBuilding(
      [](const Eigen::Vector2d&) { return true; }, "m",
      [](const Eigen::Vector2d& sheet) -> Eigen::Vector2d { return Truth(sheet) + Eigen::Vector2d(37.0, 11.0); });
  ASSERT_TRUE(Eventually([&] { return Get().state() == v1::PriorMap::STATE_DIVERGED; }));
  EXPECT_THAT(Get().reason(), HasSubstr("robots have seen more"));
  EXPECT_EQ(Get().alignment().align_time().SerializeAsString(), after.alignment().align_time().SerializeAsString());
}

TEST_F(PriorTiesTest, APlanThatNobodyUsesStaysWhereItIs) {
  AlignWestAndFollow();
  const v1::PriorMap proposed = Get();
  MapBuilding([](const Eigen::Vector2d&) { return true; });
  std::this_thread::sleep_for(std::chrono::seconds(3));  // three times as long as it would take
  EXPECT_EQ(Get().SerializeAsString(), proposed.SerializeAsString());
}

TEST_F(PriorTiesTest, AMapThatNothingJoinsIsPlacedByThePlan) {
  MapBoth();
  ASSERT_OK(ImportDrawnBuilding().status());
  const v1::GlobalPose before = WhereIs("m");
  EXPECT_FALSE(IsPlaced("n"));
  EXPECT_CODE(ListPage(10, "").status(), absl::StatusCode::kFailedPrecondition) << "it is not aligned";
  ASSERT_OK_AND_ASSIGN(const auto aligned, Align());
  ASSERT_EQ(aligned.prior_map().state(), v1::PriorMap::STATE_PROPOSED) << aligned.prior_map().reason();
  EXPECT_THAT(aligned.prior_map().alignment().joined_maps(), ElementsAre("sites/s/maps/n"));
  EXPECT_GT(aligned.prior_map().alignment().tied_walls(), 20);
  EXPECT_FALSE(IsPlaced("n")) << "no person has confirmed it yet";
  const std::vector<v1::PriorAssociation> proposed = ListAssociations();
  ASSERT_EQ(static_cast<int>(proposed.size()), aligned.prior_map().alignment().tied_walls());
  for (const v1::PriorAssociation& one : proposed) EXPECT_EQ(one.state(), v1::PriorAssociation::STATE_UNUSED);
  EXPECT_CODE(ListPage(10, "nonsense").status(), absl::StatusCode::kInvalidArgument);

  ASSERT_OK(Activate().status());
  ASSERT_TRUE(Eventually([&] { return IsPlaced("n"); }));
  for (const Eigen::Vector2d& sheet : {Eigen::Vector2d(400, 100), {860, 20}, {600, 400}}) {
    const v1::GlobalPose found = WhereIs("n", InEast(sheet));
    const v1::Pose2& pose = found.pose_world_robot().pose();
    EXPECT_LT((Eigen::Vector2d(pose.x(), pose.y()) - Truth(sheet)).norm(), 0.1);
    EXPECT_THAT(found.prior_maps(), ElementsAre(kPlan));
    EXPECT_THAT(found.prior_hops(), IsEmpty()) << "nobody has asked";
  }
  v1::GetGlobalPoseRequest explain;
  explain.mutable_map_pose()->set_map("sites/s/maps/n");
  *explain.mutable_map_pose()->mutable_pose_map_robot() = convert::ToProto(PoseWithCovariance{{1.0, 2.0, 0.3}});
  explain.set_with_prior_hops(true);
  ASSERT_OK_AND_ASSIGN(const auto explained, Call(&v1::GraphService::Stub::GetGlobalPose, explain));
  EXPECT_GT(explained.global_pose().prior_hops_size(), 5);
  std::vector<double> sum(9, 0.0);
  const auto add = [&sum](const auto& share) {
    for (int i = 0; i < 9; ++i) sum[static_cast<std::size_t>(i)] += share[i];
  };
  add(explained.global_pose().base_share());
  add(explained.global_pose().robot_share());
  for (const v1::PriorHop& hop : explained.global_pose().prior_hops()) {
    EXPECT_EQ(hop.prior_map(), kPlan);
    add(hop.share());
  }
  EXPECT_FALSE(explained.global_pose().prior_hops(0).has_wall()) << "everything but the walls that the map has seen";
  for (int i = 0; i < 9; ++i) {
    EXPECT_NEAR(sum[static_cast<std::size_t>(i)], explained.global_pose().pose_world_robot().covariance(i), 1e-9);
  }
  v1::TransformPosesRequest transform;
  transform.set_source_map("sites/s/maps/n");
  transform.set_target_map("sites/s/maps/m");
  transform.add_poses()->mutable_pose();
  ASSERT_OK_AND_ASSIGN(const auto moved, Call(&v1::GraphService::Stub::TransformPoses, transform));
  EXPECT_TRUE(moved.has_pose_target_source()) << "though no link point leads there";
  const std::vector<v1::PriorAssociation> active = ListAssociations();
  ASSERT_EQ(active.size(), proposed.size());
  int used = 0;
  for (std::size_t i = 0; i < active.size(); ++i) {
    EXPECT_EQ(active[i].wall(), proposed[i].wall());
    EXPECT_THAT(active[i].map(), ::testing::AnyOf("sites/s/maps/m", "sites/s/maps/n"));
    if (active[i].state() != v1::PriorAssociation::STATE_USED) continue;
    ++used;
    EXPECT_LT(std::abs(active[i].across_m()), 0.15);
    EXPECT_LE(active[i].chi2(), 9.22);
  }
  EXPECT_GT(used, 0.9 * static_cast<double>(active.size()));

  ASSERT_OK(Suspend().status());
  ASSERT_TRUE(Eventually([&] { return !IsPlaced("n"); }));
  const v1::GlobalPose after = WhereIs("m");
  EXPECT_EQ(after.pose_world_robot().SerializeAsString(), before.pose_world_robot().SerializeAsString());
  EXPECT_THAT(after.prior_maps(), IsEmpty());
}

TEST_F(PriorTiesTest, DoorsOfThePlanArePredicted) {
  MapBuilding(IsWest);
  prior::PlanGraph plan = prior::DrawnBuilding();
  for (const double x : {2.0, 22.0, 30.0}) plan.doors.push_back({{20 * x, 200}, {20 * x + 20, 200}});
  ASSERT_OK(ImportPlan(prior::WriteGeoJsonPlan(plan), Manifest()).status());
  ASSERT_OK(Align().status());
  MakeMap("beyond");
  v1::CreateLinkPointRequest known;
  known.set_parent("sites/s");
  known.set_link_point_id("door");
  v1::Anchor& other = *known.mutable_link_point()->add_anchors();
  other.set_map("sites/s/maps/beyond");
  other.mutable_pose_map_place()->mutable_pose()->set_x(1.0);
  v1::Anchor& anchor = *known.mutable_link_point()->add_anchors();
  anchor.set_map("sites/s/maps/m");
  const Eigen::Vector2d at = Truth({450, 196});
  anchor.mutable_pose_map_place()->mutable_pose()->set_x(at.x());
  anchor.mutable_pose_map_place()->mutable_pose()->set_y(at.y());
  ASSERT_OK(Call(&v1::LinkPointService::Stub::CreateLinkPoint, known).status());
  v1::ListPredictedLinkPointsRequest request;
  request.set_parent(kPlan);
  ASSERT_OK_AND_ASSIGN(const auto doors, Call(&v1::PriorMapService::Stub::ListPredictedLinkPoints, request));
  ASSERT_EQ(doors.predicted_size(), 3);
  for (int i = 0; i < 3; ++i) {
    const v1::PredictedLinkPoint& door = doors.predicted(i);
    EXPECT_EQ(door.door(), i);
    EXPECT_NEAR(door.width_m(), 1.0, 0.1);
    const Eigen::Vector2d truth =
        Truth(0.5 * (plan.doors[static_cast<std::size_t>(i)].from + plan.doors[static_cast<std::size_t>(i)].to));
    const v1::Pose2& place = door.pose_world_place();
    EXPECT_LT((Eigen::Vector2d(place.x(), place.y()) - truth).norm(), 0.3);
    EXPECT_NEAR(std::abs(std::sin(place.yaw() - 0.3)), 1.0, 0.01) << "through the wall";
    EXPECT_EQ(door.link_point(), i == 1 ? "sites/s/linkPoints/door" : "");
    EXPECT_EQ(door.seen(), i < 2);
  }
}

TEST_F(PriorTiesTest, APlanThatNoLongerFitsDiverges) {
  MapBoth();
  ASSERT_OK(ImportDrawnBuilding().status());
  v1::AlignPriorMapRequest request;
  request.set_activate(true);
  ASSERT_OK(Align(request).status());
  ASSERT_TRUE(Eventually([&] { return IsPlaced("n"); }));
  // A person joins the maps, and is sure of it, but wrong by half a metre.
  v1::CreateLinkPointRequest door;
  door.set_parent("sites/s");
  door.set_link_point_id("door");
  for (const bool is_west : {true, false}) {
    v1::Anchor& anchor = *door.mutable_link_point()->add_anchors();
    anchor.set_map(is_west ? "sites/s/maps/m" : "sites/s/maps/n");
    const Eigen::Vector2d at =
        is_west ? Truth({400, 100}) : Eigen::Vector2d(InEast({400, 100}) + Eigen::Vector2d(0.5, 0));
    anchor.mutable_pose_map_place()->mutable_pose()->set_x(at.x());
    anchor.mutable_pose_map_place()->mutable_pose()->set_y(at.y());
    anchor.mutable_pose_map_place()->mutable_pose()->set_yaw(is_west ? 0.3 : -1.1);
  }
  ASSERT_OK(Call(&v1::LinkPointService::Stub::CreateLinkPoint, door).status());
  ASSERT_TRUE(Eventually([&] { return Get().state() == v1::PriorMap::STATE_DIVERGED; }));
  EXPECT_THAT(Get().reason(), HasSubstr("link points disagree"));
  EXPECT_TRUE(IsPlaced("n")) << "by the link point, as without the plan";
}

}  // namespace
}  // namespace enfilade::testing
