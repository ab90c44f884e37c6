// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cmath>

#include "core/graph/geojson.h"
#include "core/graph/global_pose.h"
#include "core/graph/graph_optimization.h"
#include "nlohmann/json.hpp"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/graph/scene.h"

namespace enfilade::graph {
namespace {

using testing::Graph;
using testing::L;
using testing::M;
using testing::Numbered;
using testing::PoseNear;

// map_manager's canonical scenario: M0 in, M1 out, M2 in, M3 out; L0 joins M0 and M1, L1 M1 and M2, L2 M2 and M3,
// L3 M3 and M0, L4 M0 and M2; L3 and L4 close candidates seen before.
class Figure1Test : public ::testing::Test {
 protected:
  Anchor See(const std::string& map, const Pose2& T_world_place) const {
    const auto index = static_cast<std::size_t>(map.back() - '0');
    return testing::AnchorIn(map, Between(T_world_maps_[index], T_world_place));
  }
  void Apply(const std::vector<std::string>& maps, const std::vector<LinkPoint>& link_points) {
    graph_ = Graph(maps, link_points, graph_);
  }

  const std::vector<Pose2> T_world_maps_ = {{0, 0, 0}, {12, 3, 0.4}, {9, 15, 2.0}, {-4, 11, -2.5}};
  const std::vector<Pose2> T_world_places_ = {{8, 1, 0.2}, {14, 10, 1.5}, {3, 16, 3.0}, {-2, 4, -1.2}, {4, 7, 1.6}};
  GraphSnapshot graph_;
};

TEST_F(Figure1Test, GrowsAsToldAndClosesToTheIdentity) {
  const auto& place = T_world_places_;
  Apply({"m0"}, {});
  Apply({}, {testing::Joining("lc0", {See("m0", place[3])})});
  Apply({"m1"}, {testing::Joining("l0", {See("m0", place[0]), See("m1", place[0])})});
  Apply({"m2"}, {testing::Joining("l1", {See("m1", place[1]), See("m2", place[1])})});
  Apply({}, {testing::Joining("lc1", {See("m2", place[4])})});
  Apply({"m3"}, {testing::Joining("l2", {See("m2", place[2]), See("m3", place[2])})});
  // Both closures promote the candidate: it keeps its id.
  Apply({}, {testing::Joining("lc0", {See("m0", place[3]), See("m3", place[3])})});
  Apply({}, {testing::Joining("lc1", {See("m2", place[4]), See("m0", place[4])})});

  EXPECT_EQ(graph_.map_count(), 4u);
  EXPECT_EQ(graph_.link_point_count(), 5u);
  std::size_t edges = 0;
  for (const MapInGraph* map : graph_.ListMaps()) {
    const std::size_t n = graph_.map_node(graph_.MapSlot(map->id)).doorways.size();
    edges += n * (n - 1) / 2;
  }
  EXPECT_EQ(edges, 8u);

  // Around the loop M0, M1, M2, M3 and back.
  Pose2 around;
  const std::vector<std::string> doors = {"l0", "l1", "l2", "lc0"};
  for (std::size_t i = 0; i < doors.size(); ++i) {
    const LinkPoint& door = *graph_.FindLinkPoint(L(doors[i]));
    around =
        around *
        TransformAcross(*door.FindAnchor(M(Numbered("m", i))), *door.FindAnchor(M(Numbered("m", (i + 1) % 4)))).pose;
  }
  EXPECT_THAT(around, PoseNear(Pose2{}, 1e-12, 1e-12));

  const WorldPoses poses(graph_);
  for (std::size_t i = 0; i < 4; ++i) {
    ASSERT_OK_AND_ASSIGN(const std::optional<GlobalPose> pose, poses.Find(M(Numbered("m", i))));
    EXPECT_THAT(pose.value().T_world_robot.pose, PoseNear(T_world_maps_[i], 1e-12, 1e-12));
    EXPECT_LE(pose->hops.size(), 1u);
  }
  ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(graph_));
  EXPECT_LT(solution.chi2_after, 1e-12);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_THAT(solution.map_poses.at(M(Numbered("m", i))).pose, PoseNear(T_world_maps_[i], 1e-6, 1e-7));
  }

  const nlohmann::json json = nlohmann::json::parse(GraphToGeoJson(poses));
  EXPECT_EQ(json["features"].size(), 4u + 5u + 8u);
}

}  // namespace
}  // namespace enfilade::graph
