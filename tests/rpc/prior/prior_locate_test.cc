// SPDX-License-Identifier: Apache-2.0
// LocateInPriorMap: a robot that drives through a drawn building is found in its plan, by scans and by a session.
#include <chrono>
#include <cmath>

#include "client/sdk/api/localization.h"
#include "core/prior/formats/geojson_plan.h"
#include "enfilade/v1/prior_map_service.grpc.pb.h"
#include "fmt/format.h"
#include "proto/convert/geometry.h"
#include "proto/convert/record.h"
#include "tests/rpc/prior/prior_map_fixture.h"
#include "tests/unit/core/slam/synthetic_drive.h"

namespace enfilade::testing {
namespace {

using Eigen::Vector2d;
using ::testing::HasSubstr;

constexpr auto kLocate = &v1::PriorMapService::Stub::LocateInPriorMap;
constexpr double kMetresPerUnit = 0.05;  // of the drawn building
// The stated error, m, of a robot that is confident of its place, and rad.
constexpr double kPlaceError = 0.4;
constexpr double kYawError = 0.1;

// A point of the sheet in the building, m: y points up.
Vector2d InBuilding(const Vector2d& sheet) { return kMetresPerUnit * Vector2d(sheet.x(), -sheet.y()); }

std::vector<Wall> WallsOf(const prior::PlanGraph& plan) {
  std::vector<Wall> walls;
  for (const prior::PlanWall& wall : plan.walls) {
    walls.push_back({InBuilding(plan.corners[static_cast<std::size_t>(wall.from)].point),
                     InBuilding(plan.corners[static_cast<std::size_t>(wall.to)].point)});
  }
  return walls;
}

struct RecordedDrive {
  std::vector<sensor::PairedScan> scans;
  std::vector<Pose2> truth;  // in the building
};

// With a scanner that sees all around, and odometry that drifts.
RecordedDrive DriveThrough(const std::vector<Vector2d>& corners, const prior::PlanGraph& building) {
  RecordedDrive drive;
  drive.truth = Drive(corners, 0.3);
  drive.scans = Record(WallsOf(building), drive.truth, {.beams = 360, .field_of_view = 2 * M_PI, .range_max = 10.0},
                       {.translation_share = 0.01, .yaw_per_metre = 0.003}, 5);
  for (sensor::PairedScan& scan : drive.scans) scan.scan.time += 1'700'000'000 * kNsPerSecond;
  return drive;
}

// Through a room, the corridor, another room, and on to the end of the corridor.
RecordedDrive LongDrive() {
  return DriveThrough(
      {{2.5, -5}, {2.5, -11.25}, {13.5, -11.25}, {13.5, -6}, {13.5, -11.25}, {28.5, -11.25}, {28.5, -17}},
      prior::DrawnBuilding());
}

class PriorLocateTest : public PriorMapFixture {
 protected:
  // The plan says that it is drawn at this scale.
  void ImportPlanAt(double metres_per_unit) const {
    prior::PlanGraph plan = prior::DrawnBuilding();
    plan.metres_per_unit = metres_per_unit;
    ASSERT_OK(ImportPlan(prior::WriteGeoJsonPlan(plan), Manifest()).status());
  }
  static v1::LocateInPriorMapRequest RequestOf(const RecordedDrive& drive) {
    return client::MakeLocateInPriorMapRequest(kPlan, drive.scans);
  }
  // It computes for many seconds on a busy machine.
  absl::StatusOr<v1::LocateInPriorMapResponse> Locate(
      const v1::LocateInPriorMapRequest& request, std::chrono::milliseconds timeout = std::chrono::minutes(5)) const {
    const auto stub = v1::PriorMapService::NewStub(connection_->channel());
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + timeout);
    v1::LocateInPriorMapResponse response;
    const absl::Status status = client::FromGrpcStatus(stub->LocateInPriorMap(&context, request, &response));
    if (!status.ok()) return status;
    return response;
  }
  static Vector2d SheetOf(const v1::PriorMapMode& mode) { return {mode.sheet_x(), mode.sheet_y()}; }
  static void ExpectAt(const v1::LocateInPriorMapResponse& located, const Pose2& truth) {
    EXPECT_TRUE(located.confident()) << located.reason();
    ASSERT_GE(located.modes_size(), 1);
    ASSERT_LE(located.modes_size(), 5);
    const v1::PriorMapMode& best = located.modes(0);
    EXPECT_LT((InBuilding(SheetOf(best)) - truth.translation()).norm(), kPlaceError);
    EXPECT_LT(std::abs(WrapAngle(best.pose_plan_robot().yaw() - truth.yaw)), kYawError);
    EXPECT_NEAR(best.metres_per_unit(), kMetresPerUnit, 0.05 * kMetresPerUnit);
    EXPECT_NEAR(best.stretch(), 1.0, 0.05);
    EXPECT_FALSE(best.mirrored());
    for (int i = 1; i < located.modes_size(); ++i) EXPECT_LE(located.modes(i).mass(), located.modes(i - 1).mass());
  }
  // A session of robot "r" in map "m" with the drive's records, mapped.
  std::string MapSession(const RecordedDrive& drive) {
    const std::string session = CreateSession(true);
    TestStream stream(*connection_, session);
    std::vector<v1::Record> records;
    for (const sensor::PairedScan& scan : drive.scans) {
      const auto next = static_cast<std::int64_t>(records.size()) + 1;
      records.push_back(convert::ToProto(sensor::Record{next, sensor::Odometry{scan.scan.time, *scan.T_odom_robot}}));
      records.push_back(convert::ToProto(sensor::Record{next + 1, scan.scan}));
    }
    const auto last = static_cast<std::int64_t>(records.size());
    EXPECT_TRUE(stream.SendBatch(records));
    EXPECT_TRUE(stream.AwaitAcknowledged(last));
    EXPECT_OK(FinishSession(session, last));
    AwaitState(session, v1::Session::STATE_MAPPED);
    return session;
  }
};

TEST_F(PriorLocateTest, FindsARobotInAPlanAtAWrongScaleThatNobodyHasAligned) {
  ImportPlanAt(kMetresPerUnit / 1.15);
  const RecordedDrive drive = LongDrive();
  ASSERT_OK_AND_ASSIGN(const auto located, Locate(RequestOf(drive)));
  ExpectAt(located, drive.truth.back());
  const v1::PriorMapMode& best = located.modes(0);
  EXPECT_GT(best.mass(), 0.9);
  EXPECT_NEAR(best.pose_plan_robot().x(), best.sheet_x() * located.metres_per_unit(), 1e-9);
  EXPECT_NEAR(best.pose_plan_robot().y(), -best.sheet_y() * located.metres_per_unit(), 1e-9) << "y points up";
  ASSERT_EQ(best.covariance_size(), 16);
  for (int i = 0; i < 4; ++i) EXPECT_GT(best.covariance(5 * i), 0) << i;
  EXPECT_FALSE(best.has_pose_world_robot());
  EXPECT_EQ(located.graph_version(), 0);
  EXPECT_NEAR(located.metres_per_unit(), kMetresPerUnit / 1.15, 1e-9);
  EXPECT_NEAR(located.travelled_m(), 48.5, 1.5);
  ASSERT_TRUE(located.has_confident_after_m());
  EXPECT_LT(located.confident_after_m(), 40.0);
  EXPECT_GT(located.matched(), 0.8);
  EXPECT_GT(located.keyframes(), 40);
  EXPECT_THAT(located.reason(), HasSubstr("one place has"));
  EXPECT_EQ(Get().state(), v1::PriorMap::STATE_NEW) << "nothing is stored";
  EXPECT_EQ(located.etag(), Get().etag());
}

TEST_F(PriorLocateTest, SaysWhereTheRobotIsInTheWorldWhileThePlanIsPlaced) {
  ImportPlanAt(kMetresPerUnit);
  MapBuilding(IsWest);
  v1::AlignPriorMapRequest align;
  for (const Vector2d& sheet : {Vector2d(0, 0), {500, 20}, {30, 400}}) *align.add_pairs() = Pair(sheet, Truth(sheet));
  ASSERT_OK_AND_ASSIGN(const auto aligned, Align(align));
  ASSERT_EQ(aligned.prior_map().state(), v1::PriorMap::STATE_PROPOSED) << aligned.prior_map().reason();
  const RecordedDrive drive = LongDrive();
  const Pose2& truth = drive.truth.back();
  const auto expect_in_world = [&](v1::PriorMap::State state) {
    SCOPED_TRACE(v1::PriorMap::State_Name(state));
    EXPECT_EQ(Get().state(), state);
    const auto located = Locate(RequestOf(drive));
    ASSERT_OK(located.status());
    ExpectAt(*located, truth);
    ASSERT_TRUE(located->modes(0).has_pose_world_robot());
    const v1::PoseWithCovariance& world = located->modes(0).pose_world_robot();
    const Vector2d at(world.pose().x(), world.pose().y());
    EXPECT_LT((at - Truth(Vector2d(truth.x, -truth.y) / kMetresPerUnit)).norm(), kPlaceError);
    EXPECT_LT(std::abs(WrapAngle(world.pose().yaw() - truth.yaw - 0.3)), kYawError) << "the plan is turned by 0.3";
    ASSERT_EQ(world.covariance_size(), 9);
    EXPECT_NEAR(world.covariance(0) + world.covariance(4),
                located->modes(0).covariance(0) + located->modes(0).covariance(5), 0.01);
    EXPECT_EQ(located->graph_version(), aligned.prior_map().alignment().graph_version());
  };
  expect_in_world(v1::PriorMap::STATE_PROPOSED);
  ASSERT_OK(Activate().status());
  expect_in_world(v1::PriorMap::STATE_ACTIVE);
  ASSERT_OK(Suspend().status());
  ASSERT_OK_AND_ASSIGN(const auto suspended, Locate(RequestOf(drive)));
  ExpectAt(suspended, truth);
  EXPECT_FALSE(suspended.modes(0).has_pose_world_robot());
}

TEST_F(PriorLocateTest, LocatesASessionByItsKeyframes) {
  ImportPlanAt(kMetresPerUnit);
  const RecordedDrive drive = LongDrive();
  v1::LocateInPriorMapRequest request;
  request.set_name(kPlan);
  request.set_session(MapSession(drive));
  ASSERT_OK_AND_ASSIGN(const auto located, Locate(request));
  ExpectAt(located, drive.truth.back());
  // The map's frame is that of the first scan.
  for (const Vector2d& sheet : {Vector2d(0, 200), {260, 200}}) {
    *request.add_pairs() = Pair(sheet, Inverse(drive.truth.front()) * InBuilding(sheet));
  }
  ASSERT_OK_AND_ASSIGN(const auto shown, Locate(request));
  ExpectAt(shown, drive.truth.back());
  EXPECT_LT(shown.confident_after_m(), located.confident_after_m());
}

TEST_F(PriorLocateTest, PairsInTheOdometryFrameSayWhereADriveBegan) {
  ImportPlanAt(kMetresPerUnit / 1.3);
  RecordedDrive drive = DriveThrough({{2.5, -5}, {2.5, -6.4}}, prior::DrawnBuilding());
  const Pose2 T_odom_building = Pose2{40.0, -7.0, 2.0} * Inverse(drive.truth.front());
  for (sensor::PairedScan& scan : drive.scans) {
    scan.T_odom_robot = T_odom_building * drive.truth.front() * *scan.T_odom_robot;
  }
  v1::LocateInPriorMapRequest request = RequestOf(drive);
  EXPECT_STATUS(Locate(request), absl::StatusCode::kInvalidArgument, HasSubstr("the robot drove 1.4 m"));
  for (const Vector2d& sheet : {Vector2d(0, 200), {260, 200}}) {
    *request.add_pairs() = Pair(sheet, T_odom_building * InBuilding(sheet));
  }
  ASSERT_OK_AND_ASSIGN(const auto located, Locate(request));
  ASSERT_GE(located.modes_size(), 1);
  EXPECT_NEAR(located.metres_per_unit(), kMetresPerUnit, 1e-6) << "by the pairs";
  EXPECT_LT((InBuilding(SheetOf(located.modes(0))) - drive.truth.back().translation()).norm(), 0.6);
  EXPECT_FALSE(located.confident()) << "it must hold for 3 m";
}

TEST_F(PriorLocateTest, EndsWithItsDeadline) {
  ImportPlanAt(kMetresPerUnit);
  const v1::LocateInPriorMapRequest request = RequestOf(LongDrive());
  EXPECT_CODE(Locate(request, std::chrono::milliseconds(300)), absl::StatusCode::kDeadlineExceeded);
  EXPECT_OK(Locate(request).status()) << "the server goes on";
}

TEST_F(PriorLocateTest, RefusesScansThatAreNoDriveOfOneRobot) {
  ImportPlanAt(kMetresPerUnit);
  const v1::LocateInPriorMapRequest good = RequestOf(DriveThrough({{2.5, -5}, {2.5, -11.25}}, prior::DrawnBuilding()));
  ASSERT_OK_AND_ASSIGN(const auto first, Locate(good));
  ASSERT_OK_AND_ASSIGN(const auto second, Locate(good));
  EXPECT_EQ(first.SerializeAsString(), second.SerializeAsString());
  EXPECT_FALSE(first.confident()) << "6 m are too few";
  const auto refused = [&](const v1::LocateInPriorMapRequest& request, const std::string& message) {
    EXPECT_STATUS(Locate(request), absl::StatusCode::kInvalidArgument, HasSubstr(message));
  };
  v1::LocateInPriorMapRequest bad;
  refused(bad, "name");
  bad.set_name(kPlan);
  refused(bad, "set either scans or session");
  bad = good;
  bad.set_session("sites/s/sessions/one");
  refused(bad, "set either scans or session");
  bad = good;
  while (bad.scans_size() <= 500) *bad.add_scans() = good.scans(0);
  refused(bad, "scans has 501 scans: at most 500");
  bad = good;
  bad.mutable_scans()->DeleteSubrange(5, bad.scans_size() - 5);
  refused(bad, "the robot drove 1.2 m from the first scan to the last: 2 m are needed");
  bad = good;
  bad.mutable_scans(3)->clear_scan();
  refused(bad, "scans[3].scan is missing");
  bad = good;
  bad.mutable_scans(3)->clear_pose_odom_robot();
  refused(bad, "scans[3] has no odometry");
  bad = good;
  bad.mutable_scans(3)->mutable_pose_odom_robot()->set_yaw(std::nan(""));
  refused(bad, "scans[3]: the odometry is not finite");
  bad = good;
  bad.mutable_scans(3)->mutable_scan()->set_angle_increment_rad(std::nan(""));
  refused(bad, "scans[3]");
  bad = good;
  for (v1::LocalizationScan& scan : *bad.mutable_scans()) {
    for (float& range : *scan.mutable_scan()->mutable_ranges_m()) range = std::nanf("");
  }
  refused(bad, "no scan has 30 hits: the best one has 0");
  bad = good;
  bad.mutable_scans()->SwapElements(3, 4);
  refused(bad, "scans[4] was taken");
}

TEST_F(PriorLocateTest, RefusesTheScansOfTwoRobots) {
  ImportPlanAt(kMetresPerUnit);
  const RecordedDrive one = DriveThrough({{2.5, -5}, {2.5, -11.25}}, prior::DrawnBuilding());
  RecordedDrive two = DriveThrough({{13.5, -6}, {13.5, -11.25}}, prior::DrawnBuilding());
  for (sensor::PairedScan& scan : two.scans) scan.T_odom_robot->x += 20;
  const auto mixed = [&](TimeNs later) {
    RecordedDrive both;
    for (std::size_t i = 0; i < 10; ++i) {
      both.scans.push_back(one.scans[i]);
      both.scans.push_back(two.scans[i]);
      both.scans.back().scan.time += later;
    }
    return Locate(RequestOf(both));
  };
  EXPECT_STATUS(mixed(kNsPerSecond / 4), absl::StatusCode::kInvalidArgument,
                HasSubstr("scans[1] is 20.0 m from scans[0] by odometry: expected scans of one robot"));
  for (sensor::PairedScan& scan : two.scans) scan.T_odom_robot->x -= 18;
  EXPECT_STATUS(mixed(kNsPerSecond / 100), absl::StatusCode::kInvalidArgument,
                HasSubstr("from scans[0] to scans[1] the odometry moves by 2.00 m in 0.010 s"));
}

TEST_F(PriorLocateTest, RefusesPairsThatDetermineNothing) {
  ImportPlanAt(kMetresPerUnit);
  const v1::LocateInPriorMapRequest good = RequestOf(DriveThrough({{2.5, -5}, {2.5, -11.25}}, prior::DrawnBuilding()));
  const auto refused = [&](const std::vector<v1::ControlPair>& pairs, const std::string& message) {
    v1::LocateInPriorMapRequest bad = good;
    bad.mutable_pairs()->Assign(pairs.begin(), pairs.end());
    EXPECT_STATUS(Locate(bad), absl::StatusCode::kInvalidArgument, HasSubstr(message));
  };
  refused({Pair({0, 0}, {0, 0}), Pair({0, 0}, {9, 9})}, "pairs 1 and 2 show the same point");
  refused({Pair({0, 0}, {std::nan(""), 0})}, "pairs[0] has a coordinate that is not finite");
  refused({Pair({0, 0}, {0, 0}), Pair({99, 0}, {9, 9}, "sites/s/maps/m")}, "pairs[1].map is \"m\": expected none");
}

TEST_F(PriorLocateTest, RefusesPlansAndSessionsThatSayTooLittle) {
  ASSERT_OK(ImportDrawnBuilding().status());  // it has neither a scale nor doors
  const RecordedDrive drive = DriveThrough({{2.5, -5}, {2.5, -11.25}}, prior::DrawnBuilding());
  v1::LocateInPriorMapRequest request = RequestOf(drive);
  EXPECT_STATUS(Locate(request), absl::StatusCode::kFailedPrecondition,
                HasSubstr("sites/s/priorMaps/plan: the plan does not tell its scale"));
  v1::PlanMeasure measure;
  measure.set_to_x(100);
  measure.set_length_m(5);
  v1::EditPriorMapRequest edit;
  edit.set_name(kPlan);
  *edit.mutable_measure() = measure;
  ASSERT_OK(Call(&v1::PriorMapService::Stub::EditPriorMap, edit).status());
  EXPECT_OK(Locate(request).status());
  measure.set_length_m(100);
  *edit.mutable_measure() = measure;
  ASSERT_OK(Call(&v1::PriorMapService::Stub::EditPriorMap, edit).status());
  EXPECT_STATUS(Locate(request), absl::StatusCode::kFailedPrecondition, HasSubstr("at most 500 m can be searched"));

  measure.set_length_m(5);
  *edit.mutable_measure() = measure;
  ASSERT_OK(Call(&v1::PriorMapService::Stub::EditPriorMap, edit).status());
  request.clear_scans();
  request.set_session("sites/s/sessions/missing");
  EXPECT_CODE(Locate(request), absl::StatusCode::kNotFound);
  request.set_session("sites/other/sessions/one");
  EXPECT_STATUS(Locate(request), absl::StatusCode::kInvalidArgument, HasSubstr("expected one of sites/s"));
  request.set_session(CreateSession(false));
  EXPECT_STATUS(Locate(request), absl::StatusCode::kFailedPrecondition, HasSubstr("is not mapped"));
  request.set_session(MapSession(DriveThrough({{2.5, -5}, {2.5, -6.4}}, prior::DrawnBuilding())));
  EXPECT_STATUS(Locate(request), absl::StatusCode::kFailedPrecondition, HasSubstr("2 m are needed"));
}

TEST_F(PriorLocateTest, PlansOfOtherSitesAreNotFound) {
  ImportPlanAt(kMetresPerUnit);
  v1::CreateSiteRequest site;
  site.set_site_id("other");
  site.mutable_site()->set_display_name("Other");
  ASSERT_OK(Call(&v1::SiteService::Stub::CreateSite, site).status());
  v1::LocateInPriorMapRequest request = RequestOf(DriveThrough({{2.5, -5}, {2.5, -11.25}}, prior::DrawnBuilding()));
  for (const char* name : {"sites/other/priorMaps/plan", "sites/s/priorMaps/missing"}) {
    request.set_name(name);
    EXPECT_STATUS(Call(kLocate, request), absl::StatusCode::kNotFound, HasSubstr(name));
  }
  ASSERT_OK(Delete());
  request.set_name(kPlan);
  EXPECT_CODE(Locate(request), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace enfilade::testing
