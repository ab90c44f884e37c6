// SPDX-License-Identifier: Apache-2.0
#include "core/rearrange/plan.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/graph/scene.h"

namespace enfilade::rearrange {
namespace {

using ::enfilade::testing::AnchorIn;
using ::enfilade::testing::Graph;
using ::enfilade::testing::Joining;
using ::enfilade::testing::L;
using ::enfilade::testing::M;
using ::enfilade::testing::PoseNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

SessionInMap Drive(const std::string& id, double from_x, double to_x) {
  SessionInMap session{SessionId(id), true, {}};
  for (int i = 0; i <= 10; ++i) {
    session.keyframes.push_back({10 * i + 1, 1000 * i, {from_x + (to_x - from_x) * i / 10, 0}});
  }
  return session;
}

// A map of two rooms: s1 drives in x = 0..10, s2 in x = 12..20; doors at both ends.
class PlanSplitTest : public ::testing::Test {
 protected:
  PlanSplitTest() {
    request_.map.id = M("both");
    request_.map.sessions = {Drive("s1", 0, 10), Drive("s2", 12, 20)};
    request_.leaving = {SessionId("s2")};
    request_.seed.id = M("east");
    request_.seed.name_prefix = "Map";
    request_.link_point = L("between");
  }
  graph::GraphSnapshot graph_ =
      Graph({"both", "west", "far"}, {Joining("near", {AnchorIn("both", {-1, 0, 0}), AnchorIn("west", {})}),
                                      Joining("end", {AnchorIn("both", {21, 0, 0}), AnchorIn("far", {})})});
  SplitRequest request_;
};

TEST_F(PlanSplitTest, SessionsAndTheirDoorsLeave) {
  const auto plan = PlanSplit(request_, graph_);
  ASSERT_OK(plan);
  ASSERT_OK(Validate(*plan));
  EXPECT_THAT(plan->moves, ElementsAre(SessionMove{SessionId("s2"), M("east"), Pose2{}}));
  ASSERT_THAT(plan->link_points, SizeIs(2));
  EXPECT_EQ(plan->link_points[0].id, L("end"));
  EXPECT_NE(plan->link_points[0].FindAnchor(M("east")), nullptr);
  EXPECT_EQ(plan->link_points[0].FindAnchor(M("both")), nullptr);
  const graph::LinkPoint& between = plan->link_points[1];
  EXPECT_EQ(between.kind, graph::LinkPointKind::kOpening);
  EXPECT_THAT(between.FindAnchor(M("both"))->T_map_place, PoseNear(Pose2{11, 0, 0}, 1e-9, 1e-9));
  EXPECT_EQ(between.direction, M("east"));
}

TEST_F(PlanSplitTest, ACutDividesASession) {
  request_.map.sessions = {Drive("s1", 0, 20)};
  request_.leaving.clear();
  request_.cuts = {{SessionId("s1"), 61, SessionId("s1b")}};
  const auto plan = PlanSplit(request_, graph_);
  ASSERT_OK(plan);
  EXPECT_EQ(plan->cuts, request_.cuts);
  EXPECT_THAT(plan->moves, ElementsAre(SessionMove{SessionId("s1b"), M("east"), Pose2{}}));
  EXPECT_THAT(plan->link_points.back().anchors[0].T_map_place, PoseNear(Pose2{11, 0, 0}, 1e-9, 1e-9));
}

TEST_F(PlanSplitTest, RefusesWhatDividesNothing) {
  request_.leaving.clear();
  EXPECT_STATUS(PlanSplit(request_, graph_), absl::StatusCode::kFailedPrecondition, HasSubstr("no session leaves"));
  request_.leaving = {SessionId("s1"), SessionId("s2")};
  EXPECT_STATUS(PlanSplit(request_, graph_), absl::StatusCode::kFailedPrecondition, HasSubstr("all its 2 sessions"));
  request_.leaving = {SessionId("s3")};
  EXPECT_STATUS(PlanSplit(request_, graph_), absl::StatusCode::kNotFound, HasSubstr("session s3"));
  request_.leaving = {SessionId("s1"), SessionId("s1")};
  EXPECT_STATUS(PlanSplit(request_, graph_), absl::StatusCode::kInvalidArgument, HasSubstr("twice"));
  request_.leaving = {SessionId("s1")};
  request_.map.sessions[0].mapped = false;
  EXPECT_STATUS(PlanSplit(request_, graph_), absl::StatusCode::kFailedPrecondition, HasSubstr("still recording"));
  request_.map.sessions[0].mapped = true;
  request_.leaving.clear();
  for (const std::int64_t sequence : {1, 102}) {
    request_.cuts = {{SessionId("s1"), sequence, SessionId("s1b")}};
    EXPECT_STATUS(PlanSplit(request_, graph_), absl::StatusCode::kFailedPrecondition, HasSubstr("nothing to cut off"));
  }
  request_.map.id = M("nowhere");
  EXPECT_STATUS(PlanSplit(request_, graph_), absl::StatusCode::kNotFound, HasSubstr("nowhere"));
}

}  // namespace
}  // namespace enfilade::rearrange
