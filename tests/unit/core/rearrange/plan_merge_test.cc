// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>
#include <random>
#include <set>

#include "core/graph/global_pose.h"
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
using ::enfilade::testing::Numbered;
using ::enfilade::testing::PoseNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

MapContent Content(const std::string& id, const std::vector<std::string>& sessions) {
  MapContent map;
  map.id = M(id);
  for (const std::string& session : sessions) map.sessions.push_back({SessionId(session), true, {}});
  return map;
}

// The hall and the lab with the gate between them at (4, 5), the yard behind the lab.
class PlanMergeTest : public ::testing::Test {
 protected:
  const Pose2 T_hall_lab_{4, 5, M_PI / 2};
  graph::GraphSnapshot graph_ =
      Graph({"hall", "lab", "yard"}, {Joining("door", {AnchorIn("hall", {4, 5, M_PI / 2}), AnchorIn("lab", {})}),
                                      Joining("gate", {AnchorIn("lab", {3, 1, 0.4}), AnchorIn("yard", {1, 2, 0.3})}),
                                      Joining("seen", {AnchorIn("lab", {-2, 1, 0})})});
  MergeRequest request_{Content("hall", {"s1"}), Content("lab", {"s2", "s3"}), {}, {}};
};

TEST_F(PlanMergeTest, MovesSessionsByTheGraph) {
  const auto plan = PlanMerge(request_, graph_);
  ASSERT_OK(plan);
  ASSERT_OK(Validate(*plan));
  ASSERT_THAT(plan->moves, SizeIs(2));
  EXPECT_EQ(plan->moves[0].session, SessionId("s2"));
  EXPECT_EQ(plan->moves[0].to, M("hall"));
  EXPECT_THAT(plan->moves[0].T_to_from, PoseNear(T_hall_lab_, 1e-12, 1e-12));
  ASSERT_THAT(plan->redirects, SizeIs(1));
  EXPECT_EQ(plan->redirects[0].from, M("lab"));
  EXPECT_THAT(plan->new_maps, IsEmpty());
  EXPECT_THAT(plan->reason, HasSubstr("map lab merged into map hall: 2 sessions"));
}

TEST_F(PlanMergeTest, TheDoorBetweenThemGoesAndTheOthersMove) {
  const auto plan = PlanMerge(request_, graph_);
  ASSERT_OK(plan);
  EXPECT_THAT(plan->removed_link_points, ElementsAre(L("door")));
  ASSERT_THAT(plan->link_points, SizeIs(2));
  const graph::LinkPoint& gate = plan->link_points[0];
  EXPECT_EQ(gate.id, L("gate"));
  EXPECT_EQ(*gate.FindAnchor(M("yard")), *graph_.FindLinkPoint(L("gate"))->FindAnchor(M("yard")));
  EXPECT_THAT(gate.FindAnchor(M("hall"))->T_map_place, PoseNear(T_hall_lab_ * Pose2{3, 1, 0.4}, 1e-12, 1e-12));
  EXPECT_TRUE(plan->link_points[1].is_candidate());
}

TEST_F(PlanMergeTest, CovariancesTurnWithTheFrame) {
  Eigen::Matrix3d covariance = Eigen::Vector3d(0.01, 0.04, 0.02).asDiagonal();
  covariance(0, 2) = covariance(2, 0) = 0.003;
  graph_ = Graph({"hall", "lab", "yard"},
                 {Joining("gate", {AnchorIn("lab", {3, 1, 0.4}, covariance), AnchorIn("yard", {})})});
  request_.T_kept_merged = T_hall_lab_;
  const auto plan = PlanMerge(request_, graph_);
  ASSERT_OK(plan);
  const Eigen::Matrix3d turned = plan->link_points[0].FindAnchor(M("hall"))->covariance;
  EXPECT_NEAR(turned(0, 0), 0.04, 1e-12);
  EXPECT_NEAR(turned(1, 1), 0.01, 1e-12);
  EXPECT_NEAR(turned(1, 2), 0.003, 1e-12);
  EXPECT_NEAR(turned(2, 2), 0.02, 1e-12);
}

TEST_F(PlanMergeTest, TwoOfOneDoorBecomeOne) {
  graph_ =
      Graph({"hall", "lab", "yard"},
            {Joining("door", {AnchorIn("hall", {4, 5, M_PI / 2}), AnchorIn("lab", {})}),
             Joining("gate", {AnchorIn("lab", {3, 1, 0.4}), AnchorIn("yard", {1, 2, 0.3})}),
             Joining("gate2", {AnchorIn("hall", T_hall_lab_ * Pose2{3.1, 1, 0.4}), AnchorIn("yard", {1.1, 2, 0.3})}),
             Joining("seen", {AnchorIn("hall", T_hall_lab_ * Pose2{-2, 1.1, 0})}),
             Joining("seen2", {AnchorIn("lab", {-2, 1, 0})})});
  const auto plan = PlanMerge(request_, graph_);
  ASSERT_OK(plan);
  EXPECT_THAT(plan->removed_link_points, ElementsAre(L("door"), L("gate"), L("seen2")));
  EXPECT_THAT(plan->link_points, IsEmpty());
}

TEST_F(PlanMergeTest, ALiftThatJoinsBothAndAThirdKeepsTheThird) {
  graph_ = Graph({"hall", "lab", "yard"},
                 {Joining("lift", {AnchorIn("hall", {4, 5, M_PI / 2}), AnchorIn("lab", {}), AnchorIn("yard", {})})});
  const auto plan = PlanMerge(request_, graph_);
  ASSERT_OK(plan);
  EXPECT_THAT(plan->removed_link_points, IsEmpty());
  ASSERT_THAT(plan->link_points, SizeIs(1));
  EXPECT_THAT(plan->link_points[0].anchors, SizeIs(2));
  EXPECT_EQ(plan->link_points[0].FindAnchor(M("lab")), nullptr);
}

TEST_F(PlanMergeTest, TheRootStays) {
  std::swap(request_.kept, request_.merged);
  const auto plan = PlanMerge(request_, graph_);
  ASSERT_OK(plan);
  EXPECT_EQ(plan->redirects[0].from, M("lab"));
  EXPECT_THAT(plan->redirects[0].T_to_from, PoseNear(T_hall_lab_, 1e-12, 1e-12));
}

TEST_F(PlanMergeTest, AGivenPoseIsTakenAsItIs) {
  request_.T_kept_merged = Pose2{1, 2, 3};
  EXPECT_EQ(PlanMerge(request_, graph_)->moves[0].T_to_from, (Pose2{1, 2, 3}));
}

TEST_F(PlanMergeTest, RefusesWhatCannotBeOneRoom) {
  MergeRequest wrong = request_;
  wrong.merged = wrong.kept;
  EXPECT_STATUS(PlanMerge(wrong, graph_), absl::StatusCode::kInvalidArgument, HasSubstr("with itself"));
  wrong = request_;
  wrong.merged.level = 2;
  EXPECT_STATUS(PlanMerge(wrong, graph_), absl::StatusCode::kInvalidArgument, HasSubstr("level 2"));
  wrong = request_;
  wrong.merged.environment = Environment::kOutdoor;
  EXPECT_STATUS(PlanMerge(wrong, graph_), absl::StatusCode::kInvalidArgument, HasSubstr("outdoors"));
  wrong = request_;
  wrong.merged.id = M("nowhere");
  EXPECT_STATUS(PlanMerge(wrong, graph_), absl::StatusCode::kNotFound, HasSubstr("nowhere"));
  wrong = request_;
  wrong.T_kept_merged = Pose2{0, NAN, 0};
  EXPECT_STATUS(PlanMerge(wrong, graph_), absl::StatusCode::kInvalidArgument, HasSubstr("not finite"));
  wrong = request_;
  wrong.merged.sessions[1].mapped = false;
  EXPECT_STATUS(PlanMerge(wrong, graph_), absl::StatusCode::kFailedPrecondition, HasSubstr("session s3"));
}

TEST_F(PlanMergeTest, RefusesWithoutASurePose) {
  const graph::GraphSnapshot apart = Graph({"hall", "lab"}, {});
  EXPECT_STATUS(PlanMerge(request_, apart), absl::StatusCode::kFailedPrecondition, HasSubstr("no link points lead"));
  const graph::GraphSnapshot vague =
      Graph({"hall", "lab"},
            {Joining("door", {AnchorIn("hall", {}, Eigen::Vector3d(4, 4, 0.01).asDiagonal()), AnchorIn("lab", {})})});
  EXPECT_STATUS(PlanMerge(request_, vague), absl::StatusCode::kFailedPrecondition, HasSubstr("not sure"));
  request_.T_kept_merged = Pose2{};
  EXPECT_OK(PlanMerge(request_, vague));
}

TEST_F(PlanMergeTest, TheMapsOriginsMayBeFarFromTheirDoor) {
  graph_ = Graph({"hall", "lab"}, {Joining("door", {AnchorIn("hall", {4, 5, 0}), AnchorIn("lab", {60, -80, 0.3})})});
  EXPECT_OK(PlanMerge(request_, graph_));
}

// A campus in the plainest form: which sessions are in which map, and the graph.
struct Campus {
  graph::GraphSnapshot graph;
  std::map<MapId, std::set<SessionId>> sessions;
  std::map<MapId, MapId> redirects;
  std::map<SessionId, Pose2> T_map_session;

  MapId Resolve(MapId map) const {
    while (redirects.contains(map)) map = redirects.at(map);
    return map;
  }
  MapContent Of(const MapId& id) const {
    MapContent map;
    map.id = id;
    for (const SessionId& session : sessions.at(id)) map.sessions.push_back({session, true, {}});
    return map;
  }
  void Apply(const Rearrangement& plan) {
    ASSERT_OK(Validate(plan));
    for (const SessionMove& move : plan.moves) {
      for (auto& [map, members] : sessions) members.erase(move.session);
      sessions[move.to].insert(move.session);
      T_map_session[move.session] = move.T_to_from * T_map_session[move.session];
    }
    graph::SnapshotChanges changes{.version = graph.version() + 1};
    changes.removed_link_points = plan.removed_link_points;
    changes.link_points = plan.link_points;
    for (const MapRedirect& redirect : plan.redirects) {
      redirects[redirect.from] = redirect.to;
      sessions.erase(redirect.from);
      changes.removed_maps.push_back(redirect.from);
    }
    auto next = graph::Apply(graph, changes);
    ASSERT_OK(next);
    graph = *std::move(next);
  }
  // Sets of sessions, without the names of their maps.
  std::set<std::set<SessionId>> Partition() const {
    std::set<std::set<SessionId>> partition;
    for (const auto& [map, members] : sessions) partition.insert(members);
    return partition;
  }
};

// Nine maps in a row of rooms, every map joined to the next, three maps for each room.
Campus ThreeRooms() {
  Campus campus;
  std::vector<std::string> maps;
  std::vector<graph::LinkPoint> doors;
  for (int i = 0; i < 9; ++i) {
    maps.push_back(Numbered("m", i));
    campus.sessions[M(maps.back())] = {SessionId(Numbered("s", 2 * i)), SessionId(Numbered("s", 2 * i + 1))};
    campus.T_map_session[SessionId(Numbered("s", 2 * i))] = {0.5, 0.1 * i, 0.2};
    if (i == 0) continue;
    doors.push_back(Joining(Numbered("l", i), {AnchorIn(Numbered("m", i - 1), {5, 0.3 * i, 0.1 * i}),
                                               AnchorIn(Numbered("m", i), {-1, 0.2, 0.05})}));
  }
  campus.graph = Graph(maps, doors);
  return campus;
}

TEST(MergeOrderTest, AThousandOrdersGiveOnePartition) {
  std::mt19937_64 random(18001);
  const Campus start = ThreeRooms();
  std::set<std::set<std::set<SessionId>>> partitions;
  std::map<SessionId, Pose2> T_root_session;
  for (int trial = 0; trial < 1000; ++trial) {
    Campus campus = start;
    std::vector<std::pair<int, int>> merges = {{0, 1}, {1, 2}, {3, 4}, {4, 5}, {6, 7}, {7, 8}};
    std::shuffle(merges.begin(), merges.end(), random);
    for (auto [a, b] : merges) {
      if (random() % 2 == 0) std::swap(a, b);
      const MapId kept = campus.Resolve(M(Numbered("m", a)));
      const MapId merged = campus.Resolve(M(Numbered("m", b)));
      const auto plan = PlanMerge({campus.Of(kept), campus.Of(merged), {}, {}}, campus.graph);
      ASSERT_OK(plan);
      campus.Apply(*plan);
    }
    partitions.insert(campus.Partition());
    EXPECT_EQ(campus.graph.map_count(), 3U);
    EXPECT_EQ(campus.graph.link_point_count(), 2U);
    EXPECT_EQ(campus.graph.root(), M("m0"));
    // The world does not move either.
    for (const auto& [map, members] : campus.sessions) {
      const auto T_root_map = graph::FindTransform(campus.graph, M("m0"), map);
      ASSERT_OK(T_root_map);
      for (const SessionId& session : members) {
        const Pose2 place = (*T_root_map)->T_a_b.pose * campus.T_map_session[session];
        const auto [known, is_new] = T_root_session.emplace(session, place);
        EXPECT_THAT(place, PoseNear(known->second, 1e-9, 1e-9)) << session.value();
      }
    }
  }
  EXPECT_THAT(partitions, SizeIs(1));
}

}  // namespace
}  // namespace enfilade::rearrange
