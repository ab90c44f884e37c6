// SPDX-License-Identifier: Apache-2.0
// LocalizeRobot over a mapped session: by scans, by an image, with priors, and what it refuses.
#include "client/sdk/api/localization.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "client/sdk/api/evidence.h"
#include "client/simulator/campus/shipped_campuses.h"
#include "client/simulator/simulation.h"
#include "core/sensor/scan_pairing.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "enfilade/v1/localization_service.grpc.pb.h"
#include "proto/convert/geometry.h"
#include "proto/convert/record.h"
#include "tests/rpc/server_test.h"
#include "tests/support/pose_matchers.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;

constexpr auto kLocalize = &v1::LocalizationService::Stub::LocalizeRobot;

simulator::Drive SimulatedDrive(std::uint64_t seed) {
  simulator::SimulationOptions options = simulator::RoomsOptions();
  options.seed = seed;
  options.laps = 1;
  auto drive = simulator::SimulateRooms(options);
  EXPECT_OK(drive);
  return *std::move(drive);
}

std::string PngAt(const Pose2& T_campus_robot, std::uint64_t seed) {
  const simulator::World world(simulator::ShippedCampus("figure1").value());
  const std::string level = world.campus().robots.front().level;
  const auto frame = simulator::ReadCamera({world, level, T_campus_robot}, {}, Noise(seed)).GreyPng();
  EXPECT_OK(frame);
  return frame.ok() ? *frame : "";
}

class LocalizationTest : public ServerTest {
 protected:
  // Maps a drive through the rooms into map "m".
  void MapRooms() {
    const simulator::Drive drive = SimulatedDrive(1);
    T_campus_map_ = drive.truth.poses.front().T_campus_robot;
    const std::string session = CreateSession(true);
    TestStream stream(*connection_, session);
    std::vector<v1::Record> batch;
    std::int64_t sequence = 0;
    for (const simulator::SimulatedRecord& entry : drive.records) {
      batch.push_back(convert::ToProto(sensor::Record{++sequence, entry.payload}));
      if (batch.size() < 200 && sequence < static_cast<std::int64_t>(drive.records.size())) continue;
      ASSERT_TRUE(stream.SendBatch(batch));
      batch.clear();
    }
    ASSERT_TRUE(stream.AwaitAcknowledged(sequence));
    ASSERT_OK(FinishSession(session, sequence));
    AwaitState(session, v1::Session::STATE_MAPPED);
  }

  // The scans of another drive, with other noise, up to the `last`-th one, and the true pose there.
  struct Query {
    std::vector<sensor::PairedScan> scans;
    Pose2 T_map_robot;
  };
  Query QueryOf(std::size_t first, std::size_t last) const {
    const simulator::Drive drive = SimulatedDrive(77);
    sensor::ScanPairing pairing{sensor::ScanPairingOptions{}};
    std::vector<sensor::PairedScan> scans;
    for (const simulator::SimulatedRecord& entry : drive.records) {
      if (const auto* scan = std::get_if<sensor::LaserScan>(&entry.payload)) pairing.Add(1, *scan, scans);
      if (const auto* odometry = std::get_if<sensor::Odometry>(&entry.payload)) pairing.Add(*odometry, scans);
    }
    pairing.Flush(scans);
    Query query;
    query.scans.assign(scans.begin() + static_cast<std::ptrdiff_t>(first),
                       scans.begin() + static_cast<std::ptrdiff_t>(last) + 1);
    query.T_map_robot = Between(T_campus_map_, drive.truth.poses[last].T_campus_robot);
    return query;
  }

  static Pose2 PoseOf(const v1::LocatedPose& pose) { return convert::FromProto(pose.pose_map_robot().pose()); }

  absl::Status StatusOfCall(const v1::LocalizeRobotRequest& request) const { return Call(kLocalize, request).status(); }

  const SiteId site_{"s"};
  Pose2 T_campus_map_;
};

TEST_F(LocalizationTest, FindsARobotInAMappedSession) {
  MapRooms();
  for (const std::size_t last : {60U, 150U, 240U}) {
    const Query query = QueryOf(last - 20, last);
    const std::vector<sensor::PairedScan> one = {query.scans.back()};
    for (const auto& scans : {one, query.scans}) {
      ASSERT_OK_AND_ASSIGN(const auto found, client::LocalizeRobot(*connection_, site_, scans));
      ASSERT_GE(found.poses_size(), 1) << found.reason();
      const v1::LocatedPose& best = found.poses(0);
      EXPECT_EQ(best.map(), "sites/s/maps/m");
      EXPECT_THAT(PoseOf(best), PoseNear(query.T_map_robot, 0.15, 0.05)) << found.reason();
      EXPECT_EQ(best.pose_map_robot().covariance_size(), 9);
      EXPECT_GT(best.score(), 0.8);
      EXPECT_EQ(best.log_odds_behind(), 0.0);
      ASSERT_TRUE(best.has_pose_world_robot()) << "map m is the root";
      EXPECT_EQ(best.pose_world_robot().pose().x(), best.pose_map_robot().pose().x());
      EXPECT_EQ(found.maps_searched(), 1);
      EXPECT_GT(found.graph_version(), 0);
      EXPECT_NE(found.reason(), "");
    }
  }
}

TEST_F(LocalizationTest, APriorDecidesWhereToSearch) {
  MapRooms();
  v1::CreateMapRequest map;
  map.set_parent("sites/s");
  map.set_map_id("upstairs");
  map.mutable_map()->set_display_name("Upstairs");
  map.mutable_map()->set_level(1);
  ASSERT_OK(Call(&v1::MapService::Stub::CreateMap, map));
  const Query query = QueryOf(150, 150);
  const auto locate = [&](const v1::LocalizationPrior& prior) {
    const auto found = client::LocalizeRobot(*connection_, site_, query.scans, prior);
    EXPECT_OK(found);
    return found.ok() ? *found : v1::LocalizeRobotResponse();
  };
  v1::LocalizationPrior prior;
  prior.set_level(1);
  EXPECT_EQ(locate(prior).poses_size(), 0);
  EXPECT_EQ(locate(prior).maps_searched(), 0) << "nothing was mapped upstairs";
  prior.set_level(0);
  EXPECT_GE(locate(prior).poses_size(), 1);
  prior.set_map("sites/s/maps/upstairs");
  EXPECT_EQ(locate(prior).poses_size(), 0);
  prior.clear_level();
  prior.set_map("sites/s/maps/m");
  EXPECT_GE(locate(prior).poses_size(), 1);
  PoseWithCovariance pose{query.T_map_robot, Eigen::Vector3d(0.25, 0.25, 0.04).asDiagonal()};
  *prior.mutable_pose_map_robot() = convert::ToProto(pose);
  ASSERT_GE(locate(prior).poses_size(), 1);
  EXPECT_THAT(PoseOf(locate(prior).poses(0)), PoseNear(query.T_map_robot, 0.15, 0.05));
  pose.pose.x += 100.0;
  *prior.mutable_pose_map_robot() = convert::ToProto(pose);
  EXPECT_EQ(locate(prior).poses_size(), 0);
}

TEST_F(LocalizationTest, ANewRevisionIsSearchedAtOnce) {
  const Query query = QueryOf(150, 150);
  ASSERT_OK_AND_ASSIGN(const auto before, client::LocalizeRobot(*connection_, site_, query.scans));
  EXPECT_EQ(before.poses_size(), 0);
  EXPECT_EQ(before.maps_searched(), 0);
  EXPECT_THAT(before.reason(), HasSubstr("no map"));
  MapRooms();
  ASSERT_OK_AND_ASSIGN(const auto mapped, client::LocalizeRobot(*connection_, site_, query.scans));
  EXPECT_EQ(mapped.poses_size() > 0, true) << mapped.reason();
  v1::DeleteMapRequest remove;
  remove.set_name("sites/s/maps/m");
  remove.set_force(true);
  ASSERT_OK(Call(&v1::MapService::Stub::DeleteMap, remove));
  ASSERT_OK_AND_ASSIGN(const auto removed, client::LocalizeRobot(*connection_, site_, query.scans));
  EXPECT_EQ(removed.poses_size(), 0);
}

TEST_F(LocalizationTest, AnImageRanksThePlacesWithKeptImages) {
  const Pose2 seen{2.0, 2.0, 0.0};
  const Pose2 elsewhere{2.0, 2.0, M_PI / 2.0};
  for (const auto& [id, T_campus_robot] : {std::pair("here", seen), std::pair("there", elsewhere)}) {
    v1::CreateLinkPointRequest create;
    create.set_parent("sites/s");
    create.set_link_point_id(id);
    create.mutable_link_point()->set_kind(v1::LinkPoint::KIND_DOOR);
    v1::Anchor& anchor = *create.mutable_link_point()->add_anchors();
    anchor.set_map("sites/s/maps/m");
    *anchor.mutable_pose_map_place() =
        convert::ToProto(PoseWithCovariance{T_campus_robot, 0.01 * Eigen::Matrix3d::Identity()});
    ASSERT_OK(Call(&v1::LinkPointService::Stub::CreateLinkPoint, create));
    v1::Evidence evidence;
    evidence.set_map("sites/s/maps/m");
    evidence.mutable_image()->set_camera(v1::Image::CAMERA_FRONT);
    evidence.mutable_image()->set_encoding(v1::Image::ENCODING_PNG);
    *evidence.mutable_image()->mutable_time() = convert::ToTimestamp(1'700'000'000 * kNsPerSecond);
    ASSERT_OK(client::AttachEvidence(*connection_, std::string("sites/s/linkPoints/") + id, evidence,
                                     PngAt(T_campus_robot, 1)));
  }
  v1::LocalizeRobotRequest request;
  request.set_site("sites/s");
  request.mutable_image()->set_content(PngAt({2.1, 2.05, 0.02}, 9));
  ASSERT_OK_AND_ASSIGN(const auto found, Call(kLocalize, request));
  ASSERT_GE(found.places_size(), 1) << found.reason();
  EXPECT_EQ(found.places(0).link_point(), "sites/s/linkPoints/here");
  EXPECT_EQ(found.places(0).map(), "sites/s/maps/m");
  EXPECT_TRUE(found.places(0).accepted());
  EXPECT_GT(found.places(0).matches(), 30);
  EXPECT_EQ(found.poses_size(), 0) << "an image alone gives no pose";
  for (int i = 1; i < found.places_size(); ++i) EXPECT_LT(found.places(i).matches(), found.places(0).matches());

  request.mutable_prior()->set_level(3);
  ASSERT_OK_AND_ASSIGN(const auto none, Call(kLocalize, request));
  EXPECT_EQ(none.places_size(), 0);
  request.clear_prior();
  request.mutable_image()->set_content("not an image");
  EXPECT_STATUS(StatusOfCall(request), absl::StatusCode::kInvalidArgument, HasSubstr("image"));
}

TEST_F(LocalizationTest, RefusesWhatItCannotSearch) {
  const Query query = QueryOf(150, 150);
  const v1::LocalizeRobotRequest good = client::MakeLocalizeRequest(site_, query.scans);
  ASSERT_OK(StatusOfCall(good));
  v1::LocalizeRobotRequest bad;
  EXPECT_CODE(StatusOfCall(bad), absl::StatusCode::kInvalidArgument);
  bad.set_site("sites/s");
  EXPECT_STATUS(StatusOfCall(bad), absl::StatusCode::kInvalidArgument, HasSubstr("scans"));
  bad = good;
  bad.set_site("sites/elsewhere");
  EXPECT_CODE(StatusOfCall(bad), absl::StatusCode::kNotFound);
  bad = good;
  while (bad.scans_size() <= 100) *bad.add_scans() = good.scans(0);
  EXPECT_STATUS(StatusOfCall(bad), absl::StatusCode::kInvalidArgument, HasSubstr("at most 100"));
  bad = good;
  bad.mutable_scans(0)->clear_scan();
  EXPECT_STATUS(StatusOfCall(bad), absl::StatusCode::kInvalidArgument, HasSubstr("scans[0]"));
  bad = good;
  bad.mutable_scans(0)->mutable_scan()->set_angle_min_rad(std::nan(""));
  EXPECT_STATUS(StatusOfCall(bad), absl::StatusCode::kInvalidArgument, HasSubstr("scans[0]"));
  bad = good;
  for (float& range : *bad.mutable_scans(0)->mutable_scan()->mutable_ranges_m()) range = std::nanf("");
  EXPECT_STATUS(StatusOfCall(bad), absl::StatusCode::kInvalidArgument, HasSubstr("hits"));
  bad = good;
  *bad.add_scans() = good.scans(0);
  bad.mutable_scans(1)->clear_pose_odom_robot();
  EXPECT_STATUS(StatusOfCall(bad), absl::StatusCode::kInvalidArgument, HasSubstr("scans[1] has no odometry"));
  bad = good;
  bad.mutable_prior()->set_map("sites/s/maps/nowhere");
  EXPECT_CODE(StatusOfCall(bad), absl::StatusCode::kNotFound);
  bad.mutable_prior()->set_map("sites/other/maps/m");
  EXPECT_STATUS(StatusOfCall(bad), absl::StatusCode::kInvalidArgument, HasSubstr("prior.map"));
  bad = good;
  *bad.mutable_prior()->mutable_pose_map_robot() = convert::ToProto(PoseWithCovariance{});
  EXPECT_STATUS(StatusOfCall(bad), absl::StatusCode::kInvalidArgument, HasSubstr("prior"));
  bad = good;
  bad.set_max_results(51);
  EXPECT_STATUS(StatusOfCall(bad), absl::StatusCode::kInvalidArgument, HasSubstr("max_results"));
}

TEST_F(LocalizationTest, EndsWithItsDeadline) {
  MapRooms();
  v1::LocalizeRobotRequest request = client::MakeLocalizeRequest(site_, QueryOf(100, 240).scans);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::milliseconds(5));
  v1::LocalizeRobotResponse response;
  const auto stub = v1::LocalizationService::NewStub(connection_->channel());
  EXPECT_EQ(stub->LocalizeRobot(&context, request, &response).error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_OK(StatusOfCall(request)) << "the slot of the search is free again";
}

}  // namespace
}  // namespace enfilade::testing
