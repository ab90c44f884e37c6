// SPDX-License-Identifier: Apache-2.0
// Values of the graph, of doors and of streams as messages.
#include "server/rpc/graph/messages.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/graph/search_radius.h"
#include "proto/convert/geometry.h"
#include "server/rpc/ingest/stream_messages.h"
#include "server/rpc/session/door_verdict.h"
#include "tests/support/status_assertions.h"

namespace enfilade::server {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const SiteId kHq("hq");

graph::Anchor AnchorIn(const std::string& map, const Pose2& T_map_place) {
  return {MapId(map), T_map_place, graph::DefaultAnchorCovariance()};
}

// Root "a" - door "ab" - "b" with a candidate "c" in it; "far" is joined to nothing.
SiteGraph MakeGraph() {
  graph::SnapshotChanges changes{.version = 9, .root = MapId("a")};
  for (const std::string id : {"a", "b", "far"})
    changes.maps.push_back({.id = MapId(id), .display_name = "Room " + id});
  changes.maps[1].level = 1;
  graph::LinkPoint door;
  door.id = LinkPointId("ab");
  door.anchors = {AnchorIn("a", {5, 0, 0}), AnchorIn("b", {0, 0, 0})};
  graph::LinkPoint second = door;
  second.id = LinkPointId("ab-2");
  second.anchors = {AnchorIn("a", {5, 4, 0}), AnchorIn("b", {0, 4, 0})};
  graph::LinkPoint candidate;
  candidate.id = LinkPointId("c");
  candidate.anchors = {AnchorIn("b", {3, 3, 0})};
  changes.link_points = {door, second, candidate};
  auto snapshot = Apply(graph::GraphSnapshot(), changes);
  EXPECT_OK(snapshot);
  return SiteGraph(*std::move(snapshot));
}

TEST(GraphMessage, HasMapsWithTheirPlaceIfTheyAreJoined) {
  const v1::Graph out = ToProto(kHq, MakeGraph());
  EXPECT_EQ(out.site(), "sites/hq");
  EXPECT_EQ(out.graph_version(), 9);
  EXPECT_EQ(out.root_map(), "sites/hq/maps/a");
  ASSERT_EQ(out.maps_size(), 3);
  EXPECT_EQ(out.maps(1).map(), "sites/hq/maps/b");
  EXPECT_EQ(out.maps(1).display_name(), "Room b");
  EXPECT_EQ(out.maps(1).level(), 1);
  EXPECT_NEAR(out.maps(1).pose_world_map().pose().x(), 5.0, 1e-9);
  EXPECT_FALSE(out.maps(2).has_pose_world_map()) << "nothing leads to it";
  EXPECT_FALSE(out.maps(0).optimized());
}

TEST(GraphMessage, HasLinkPointsAndTheEdgesBetweenThem) {
  const v1::Graph out = ToProto(kHq, MakeGraph());
  ASSERT_EQ(out.link_points_size(), 3);
  EXPECT_THAT(out.link_points(0).maps(), ElementsAre("sites/hq/maps/a", "sites/hq/maps/b"));
  EXPECT_TRUE(out.link_points(0).joins());
  EXPECT_FALSE(out.link_points(2).joins()) << "a candidate";
  EXPECT_NEAR(out.link_points(2).pose_world_place().pose().x(), 8.0, 1e-9);
  ASSERT_EQ(out.edges_size(), 2) << "one in each room; a candidate has none";
  for (const v1::GraphEdge& edge : out.edges()) {
    EXPECT_EQ(edge.link_point_a(), "sites/hq/linkPoints/ab");
    EXPECT_EQ(edge.link_point_b(), "sites/hq/linkPoints/ab-2");
    EXPECT_DOUBLE_EQ(edge.length_m(), 4.0);
  }
}

TEST(GlobalPoseMessage, ExplainsItself) {
  const SiteGraph graph = MakeGraph();
  const PoseWithCovariance T_map_robot{{1, 0, 0}, 0.01 * Eigen::Matrix3d::Identity()};
  ASSERT_OK_AND_ASSIGN(const auto pose, graph.poses.Find(MapId("b"), T_map_robot));
  ASSERT_TRUE(pose.has_value());
  v1::GlobalPose out;
  Fill(kHq, *pose, out);
  EXPECT_NEAR(out.pose_world_robot().pose().x(), 6.0, 1e-9);
  EXPECT_EQ(out.graph_version(), 9);
  EXPECT_EQ(out.base_map(), "sites/hq/maps/a");
  EXPECT_EQ(out.solution_version(), 0) << "nothing is optimised";
  ASSERT_EQ(out.hops_size(), 1);
  EXPECT_EQ(out.hops(0).from_map(), "sites/hq/maps/a");
  EXPECT_EQ(out.hops(0).to_map(), "sites/hq/maps/b");
  // The shares add up to the covariance, as the proto promises.
  for (int i = 0; i < 9; ++i) {
    EXPECT_NEAR(out.base_share(i) + out.hops(0).share(i) + out.robot_share(i), out.pose_world_robot().covariance(i),
                1e-12);
  }
  EXPECT_DOUBLE_EQ(out.search_radius_m(), graph::SearchRadius(pose->T_world_robot.covariance));
}

TEST(GraphVersionMessage, HasTheFigureOfAnOptimisationOnly) {
  storage::GraphVersion version;
  version.version = 4;
  version.cause = storage::GraphCause::kLinkPointAdded;
  version.resource = "linkPoints/ab";
  version.actor = "ann";
  v1::GraphVersion out = ToProto(kHq, version);
  EXPECT_EQ(out.graph_version(), 4);
  EXPECT_EQ(static_cast<int>(out.cause()), static_cast<int>(storage::GraphCause::kLinkPointAdded));
  EXPECT_EQ(out.resource(), "linkPoints/ab");
  EXPECT_EQ(out.actor(), "ann");
  EXPECT_EQ(out.chi2_before(), 0.0);
  version.optimization = {.chi2_before = 8.5, .chi2_after = 0.5, .switched_off = {LinkPointId("ab")}};
  out = ToProto(kHq, version);
  EXPECT_EQ(out.chi2_before(), 8.5);
  EXPECT_EQ(out.chi2_after(), 0.5);
  EXPECT_THAT(out.switched_off(), ElementsAre("sites/hq/linkPoints/ab"));
}

TEST(RouteMessage, NamesTheExitOfEachLegButTheLast) {
  graph::Route route;
  route.length_m = 12;
  route.cost = 12;
  route.legs = {{.map = MapId("a"),
                 .level = 0,
                 .T_map_begin = {0, 0, 0},
                 .T_map_end = {5, 0, 0},
                 .length_m = 5,
                 .exit = LinkPointId("ab")},
                {.map = MapId("b"), .level = 1, .T_map_begin = {0, 0, 0}, .T_map_end = {7, 0, 0}, .length_m = 7}};
  const v1::Route out = ToProto(kHq, route);
  EXPECT_EQ(out.length_m(), 12);
  ASSERT_EQ(out.legs_size(), 2);
  EXPECT_EQ(out.legs(0).exit(), "sites/hq/linkPoints/ab");
  EXPECT_EQ(out.legs(0).pose_map_end().x(), 5);
  EXPECT_EQ(out.legs(1).exit(), "");
  EXPECT_EQ(out.legs(1).level(), 1);
}

TEST(DoorVerdictMessage, MarksWhatWasNotMeasured) {
  closure::DoorVerdict verdict;
  verdict.session = SessionId("monday");
  verdict.sequence = 77;
  verdict.decision = closure::DoorDecision::kLinkPointMade;
  verdict.reason = "seen for the first time";
  closure::DoorComparison comparison;
  comparison.link_point = LinkPointId("ab");
  comparison.map = MapId("b");
  verdict.comparisons = {comparison};
  v1::DoorVerdict out = ToProto(kHq, verdict);
  EXPECT_EQ(out.name(), "sites/hq/sessions/monday/doors/77");
  EXPECT_EQ(static_cast<int>(out.decision()), static_cast<int>(closure::DoorDecision::kLinkPointMade));
  EXPECT_EQ(out.link_point(), "");
  EXPECT_EQ(out.entered_map(), "");
  EXPECT_FALSE(out.has_pose_map_robot());
  ASSERT_EQ(out.comparisons_size(), 1);
  EXPECT_EQ(out.comparisons(0).distance_m(), -1.0);
  EXPECT_EQ(out.comparisons(0).image_matches(), -1);
  EXPECT_EQ(out.comparisons(0).registration_rmse_m(), -1.0);
  EXPECT_EQ(out.comparisons(0).chi2(), -1.0);

  verdict.comparisons[0].distance = 0.0;
  verdict.comparisons[0].image_matches = 0;
  verdict.comparisons[0].rmse = 0.0;
  verdict.comparisons[0].chi2 = 0.0;
  verdict.link_point = LinkPointId("ab");
  verdict.entered_map = MapId("b");
  out = ToProto(kHq, verdict);
  EXPECT_EQ(out.comparisons(0).distance_m(), 0.0) << "0 is a measurement";
  EXPECT_EQ(out.comparisons(0).image_matches(), 0);
  EXPECT_EQ(out.link_point(), "sites/hq/linkPoints/ab");
  EXPECT_EQ(out.entered_map(), "sites/hq/maps/b");
}

TEST(StreamMessage, SaysWhyABatchIsRefused) {
  using Reason = Refusal::Reason;
  for (const auto& [reason, expected] :
       {std::pair{Reason::kInvalidRecord, v1::BatchRefused::REASON_INVALID_RECORD},
        std::pair{Reason::kConflictingRecord, v1::BatchRefused::REASON_CONFLICTING_RECORD},
        std::pair{Reason::kInvalidBatch, v1::BatchRefused::REASON_INVALID_BATCH}}) {
    const v1::StreamRecordsResponse response =
        ToResponse(Refusal{.first_sequence = 10, .sequence = 12, .reason = reason, .message = "why"});
    EXPECT_EQ(response.refused().reason(), expected);
    EXPECT_EQ(response.refused().first_sequence(), 10);
    EXPECT_EQ(response.refused().sequence(), 12);
    EXPECT_EQ(response.refused().message(), "why");
  }
}

v1::PoseReport MakeReport() {
  v1::PoseReport report;
  report.set_map("sites/hq/maps/b");
  report.mutable_time()->set_seconds(1'700'000'000);
  *report.mutable_pose_map_robot() = convert::ToProto(PoseWithCovariance{{1, 2, 3}, 0.5 * Eigen::Matrix3d::Identity()});
  return report;
}

TEST(PoseReportMessage, ReadsMapPoseAndTime) {
  ASSERT_OK_AND_ASSIGN(const storage::RobotPose pose, ReadPoseReport(MakeReport()));
  EXPECT_EQ(pose.site, kHq);
  EXPECT_EQ(pose.map, MapId("b"));
  EXPECT_EQ(pose.time, 1'700'000'000'000'000'000);
  EXPECT_EQ(pose.T_map_robot.pose, (Pose2{1, 2, 3}));
  EXPECT_EQ(pose.T_map_robot.covariance(2, 2), 0.5);
  EXPECT_TRUE(pose.robot.empty());
  EXPECT_FALSE(pose.session.has_value());
}

TEST(PoseReportMessage, NamesTheFieldAtFault) {
  struct Case {
    const char* field;
    void (*change)(v1::PoseReport&);
  };
  for (const Case& test : {Case{"pose_report.map", [](v1::PoseReport& r) { r.set_map("maps/b"); }},
                           Case{"pose_report.pose_map_robot", [](v1::PoseReport& r) { r.clear_pose_map_robot(); }},
                           Case{"pose_report.pose_map_robot",
                                [](v1::PoseReport& r) { r.mutable_pose_map_robot()->mutable_pose()->set_x(NAN); }},
                           Case{"time", [](v1::PoseReport& r) { r.mutable_time()->set_seconds(-1); }}}) {
    v1::PoseReport report = MakeReport();
    test.change(report);
    EXPECT_STATUS(ReadPoseReport(report), absl::StatusCode::kInvalidArgument, HasSubstr(test.field));
  }
}

}  // namespace
}  // namespace enfilade::server
