// SPDX-License-Identifier: Apache-2.0
// Levels that only the shafts of their plans tie to each other.
#include <cmath>
#include <string>
#include <vector>

#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "enfilade/v1/prior_map_service.grpc.pb.h"
#include "tests/rpc/prior/prior_map_fixture.h"
#include "tests/support/eventually.h"
#include "tests/support/plans/random_building.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kWanted = 0.15;  // m, of one level relative to another

Eigen::Vector2d Turned(double turn, const Eigen::Vector2d& point) {
  return {std::cos(turn) * point.x() - std::sin(turn) * point.y(),
          std::sin(turn) * point.x() + std::cos(turn) * point.y()};
}

// Map "m" has the ground floor and is the root. Map "up" has the first floor, which has other rooms, in a frame of its
// own. Its plan "first" is drawn at another scale and turned. A lift and stairs go through both.
class PriorShaftsTest : public PriorMapFixture {
 protected:
  static constexpr const char* kFirst = "sites/s/priorMaps/first";

  // m, in the building: x to the right, y down.
  static void AddShafts(prior::PlanGraph& plan) {
    const auto add = [&](prior::ShaftKind kind, const std::string& name, double x, double y, double width,
                         double depth) {
      plan.shafts.push_back({kind,
                             {{20 * x, 20 * y},
                              {20 * (x + width), 20 * y},
                              {20 * (x + width), 20 * (y + depth)},
                              {20 * x, 20 * (y + depth)}},
                             name});
    };
    add(prior::ShaftKind::kLift, "Lift A", 12.3, 0.3, 2.0, 1.6);
    add(prior::ShaftKind::kStairs, "Stairs", 30.0, 20.0, 3.0, 2.5);
  }
  static prior::PlanGraph GroundFloor() {
    prior::PlanGraph plan = prior::DrawnBuilding();
    AddShafts(plan);
    return plan;
  }
  static prior::PlanGraph FirstFloorAsBuilt() {
    prior::PlanGraph plan = prior::RandomBuilding(7, {});
    AddShafts(plan);
    return plan;
  }
  // Its sheet, by that of the ground floor.
  static Eigen::Vector2d OnSheet(const Eigen::Vector2d& built) {
    return 0.8 * Turned(0.5, built) + Eigen::Vector2d(300, 40);
  }
  static prior::PlanGraph FirstFloor() {
    prior::PlanGraph plan = FirstFloorAsBuilt();
    for (prior::PlanCorner& corner : plan.corners) corner.point = OnSheet(corner.point);
    for (prior::PlanShaft& shaft : plan.shafts) {
      for (Eigen::Vector2d& corner : shaft.outline) corner = OnSheet(corner);
    }
    return plan;
  }
  // Where the first floor lies in map "up".
  static Eigen::Vector2d InUp(const Eigen::Vector2d& built) {
    return 0.05 * Turned(-1.9, {built.x(), -built.y()}) + Eigen::Vector2d(-8.0, 21.0);
  }

  void MapGroundFloor() {
    MapBuilding([](const Eigen::Vector2d&) { return true; });
    ASSERT_OK(ImportPlan(prior::WriteGeoJsonPlan(GroundFloor()), Manifest()).status());
  }
  void MapFirstFloor(const prior::PlanGraph& plan) {
    MakeMap("up", 1);
    ImportGrid(prior::MapOf(FirstFloorAsBuilt(), InUp, [](const Eigen::Vector2d&) { return true; }), "up");
    v1::ImportPriorMapManifest manifest = Manifest("first", "First floor");
    manifest.set_level(1);
    ASSERT_OK(ImportPlan(prior::WriteGeoJsonPlan(plan), manifest).status());
  }
  v1::PriorMap AlignAndActivate(const std::string& name) const {
    v1::AlignPriorMapRequest request;
    request.set_name(name);
    request.set_activate(true);
    const auto aligned = Align(request);
    EXPECT_OK(aligned.status());
    return aligned.ok() ? aligned->prior_map() : v1::PriorMap();
  }
  v1::GlobalPose WhereIs(const std::string& map, const Eigen::Vector2d& point = Eigen::Vector2d::Zero(),
                         bool explained = false) const {
    v1::GetGlobalPoseRequest request;
    v1::MapPose& pose = *request.mutable_map_pose();
    pose.set_map("sites/s/maps/" + map);
    pose.mutable_pose_map_robot()->mutable_pose()->set_x(point.x());
    pose.mutable_pose_map_robot()->mutable_pose()->set_y(point.y());
    request.set_with_prior_hops(explained);
    const auto response = Call(&v1::GraphService::Stub::GetGlobalPose, request);
    EXPECT_OK(response.status());
    return response.ok() ? response->global_pose() : v1::GlobalPose();
  }
  bool IsPlaced(const std::string& map) const { return WhereIs(map).has_pose_world_robot(); }
  std::vector<v1::PriorShaft> ShaftsOf(const std::string& name) const {
    v1::ListPriorAssociationsRequest request;
    request.set_parent(name);
    const auto response = Call(&v1::PriorMapService::Stub::ListPriorAssociations, request);
    EXPECT_OK(response.status());
    if (!response.ok()) return {};
    return {response->shafts().begin(), response->shafts().end()};
  }
  // A robot went up the stairs.
  void JoinByStairs() const {
    v1::CreateLinkPointRequest request;
    request.set_parent("sites/s");
    request.set_link_point_id("stairs");
    const Eigen::Vector2d built(620, 420);
    for (const bool is_up : {false, true}) {
      v1::Anchor& anchor = *request.mutable_link_point()->add_anchors();
      anchor.set_map(is_up ? "sites/s/maps/up" : "sites/s/maps/m");
      const Eigen::Vector2d at = is_up ? InUp(built) : Truth(built);
      anchor.mutable_pose_map_place()->mutable_pose()->set_x(at.x());
      anchor.mutable_pose_map_place()->mutable_pose()->set_y(at.y());
      anchor.mutable_pose_map_place()->mutable_pose()->set_yaw(is_up ? -1.9 : 0.3);
      for (const double value : {0.01, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 0.0, 0.0004}) {
        anchor.mutable_pose_map_place()->add_covariance(value);
      }
    }
    ASSERT_OK(Call(&v1::LinkPointService::Stub::CreateLinkPoint, request).status());
  }
};

TEST_F(PriorShaftsTest, ALevelThatNothingJoinsIsPlacedByItsShafts) {
  MapGroundFloor();
  MapFirstFloor(FirstFloor());
  v1::AlignPriorMapRequest first;
  first.set_name(kFirst);
  EXPECT_STATUS(Align(first).status(), absl::StatusCode::kFailedPrecondition, HasSubstr("needs two named shafts"));
  ASSERT_EQ(AlignAndActivate(kPlan).state(), v1::PriorMap::STATE_ACTIVE);
  EXPECT_THAT(ShaftsOf(kPlan), ElementsAre()) << "no other plan is in use";
  const v1::GlobalPose ground = WhereIs("m");

  ASSERT_OK_AND_ASSIGN(const auto aligned, Align(first));
  ASSERT_EQ(aligned.prior_map().state(), v1::PriorMap::STATE_PROPOSED) << aligned.prior_map().reason();
  EXPECT_THAT(aligned.prior_map().reason(), HasSubstr("the shafts Lift A, Stairs say where it lies"));
  EXPECT_THAT(aligned.prior_map().alignment().joined_maps(), ElementsAre("sites/s/maps/up"));
  EXPECT_GT(aligned.prior_map().alignment().rival_ratio(), 1.0);
  EXPECT_FALSE(IsPlaced("up")) << "no person has confirmed it yet";

  ASSERT_OK(Activate("", kFirst).status());
  ASSERT_TRUE(Eventually([&] { return IsPlaced("up"); }));
  for (const Eigen::Vector2d& built : {Eigen::Vector2d(10, 10), {860, 20}, {20, 460}, {600, 400}}) {
    const v1::GlobalPose found = WhereIs("up", InUp(built));
    const v1::Pose2& pose = found.pose_world_robot().pose();
    EXPECT_LT((Eigen::Vector2d(pose.x(), pose.y()) - Truth(built)).norm(), kWanted) << built.transpose();
    EXPECT_LT((Placed(aligned.prior_map().alignment(), OnSheet(built)) - Truth(built)).norm(), kWanted);
    EXPECT_THAT(found.prior_maps(), ElementsAre(kFirst));
  }
  for (const char* name : {kPlan, kFirst}) {
    const std::vector<v1::PriorShaft> shafts = ShaftsOf(name);
    ASSERT_EQ(shafts.size(), 2U);
    for (const v1::PriorShaft& shaft : shafts) {
      EXPECT_EQ(shaft.state(), v1::PriorAssociation::STATE_USED);
      EXPECT_EQ(shaft.other_prior_map(), name == kPlan ? kFirst : kPlan);
      EXPECT_LT(shaft.distance_m(), 0.1);
    }
  }
  std::vector<std::string> names;
  const v1::GlobalPose explained = WhereIs("up", {}, true);
  for (const v1::PriorHop& hop : explained.prior_hops()) {
    if (!hop.shaft().empty()) names.push_back(hop.shaft());
  }
  EXPECT_THAT(names, ElementsAre("Lift A", "Stairs"));

  // It is aligned again from where it lies.
  v1::AlignPriorMapRequest again = first;
  again.set_from_last(true);
  again.set_activate(true);
  ASSERT_OK_AND_ASSIGN(const auto realigned, Align(again));
  EXPECT_EQ(realigned.prior_map().state(), v1::PriorMap::STATE_ACTIVE) << realigned.prior_map().reason();
  EXPECT_LT((Placed(realigned.prior_map().alignment(), OnSheet({600, 400})) - Truth({600, 400})).norm(), kWanted);

  ASSERT_OK(Suspend("", kFirst).status());
  ASSERT_TRUE(Eventually([&] { return !IsPlaced("up"); }));
  EXPECT_EQ(WhereIs("m").pose_world_robot().SerializeAsString(), ground.pose_world_robot().SerializeAsString());
  EXPECT_THAT(ShaftsOf(kPlan), ElementsAre());
}

TEST_F(PriorShaftsTest, APlanWhoseShaftsLieElsewhereIsRefused) {
  MapGroundFloor();
  prior::PlanGraph plan = FirstFloor();
  for (prior::PlanShaft& shaft : plan.shafts) {
    for (Eigen::Vector2d& corner : shaft.outline) corner += Eigen::Vector2d(60, 30);
  }
  MapFirstFloor(plan);
  JoinByStairs();
  ASSERT_EQ(AlignAndActivate(kPlan).state(), v1::PriorMap::STATE_ACTIVE);
  ASSERT_TRUE(Eventually([&] { return IsPlaced("up"); })) << "by the link point";
  const v1::PriorMap refused = AlignAndActivate(kFirst);
  EXPECT_EQ(refused.state(), v1::PriorMap::STATE_DIVERGED);
  EXPECT_THAT(refused.reason(), HasSubstr("2 of its 2 shafts lie elsewhere than on other levels"));
}

TEST_F(PriorShaftsTest, OneShaftIsTooLittle) {
  MapGroundFloor();
  prior::PlanGraph plan = FirstFloor();
  plan.shafts[1].name = "Staircase";
  MapFirstFloor(plan);
  ASSERT_EQ(AlignAndActivate(kPlan).state(), v1::PriorMap::STATE_ACTIVE);
  v1::AlignPriorMapRequest request;
  request.set_name(kFirst);
  EXPECT_STATUS(Align(request).status(), absl::StatusCode::kFailedPrecondition, HasSubstr("and has 1"));
  EXPECT_EQ(Get(kFirst).state(), v1::PriorMap::STATE_NEW);
}

}  // namespace
}  // namespace enfilade::testing
