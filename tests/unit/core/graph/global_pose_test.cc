// SPDX-License-Identifier: Apache-2.0
#include "core/graph/global_pose.h"

#include <gmock/gmock.h>

#include <Eigen/LU>
#include <cmath>

#include "core/graph/graph_optimization.h"
#include "core/graph/search_radius.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/graph/scene.h"

namespace enfilade::graph {
namespace {

using testing::AnchorIn;
using testing::Draw;
using testing::Graph;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::Joining;
using testing::M;
using testing::Numbered;
using testing::PoseNear;
using testing::RandomCovariance;
using ::testing::SizeIs;
using testing::Uniform;
using testing::World;

GlobalPose Find(const GraphSnapshot& graph, const std::string& map, const PoseWithCovariance& T_map_robot = {}) {
  return WorldPoses(graph).Find(M(map), T_map_robot).value().value();
}

Eigen::Matrix3d SumOfShares(const GlobalPose& pose) {
  Eigen::Matrix3d sum = pose.base_share + pose.robot_share;
  for (const PoseHop& hop : pose.hops) sum += hop.share;
  return sum;
}

// A row of maps, each with its own door noise; the truth of the world is in `world`.
struct Row {
  World world;
  std::vector<Pose2> T_world_doors;
  std::vector<std::vector<Eigen::Matrix3d>> covariances;

  GraphSnapshot Seen(std::mt19937_64& random) const {
    std::vector<LinkPoint> doors;
    for (std::size_t i = 0; i < T_world_doors.size(); ++i) {
      doors.push_back(world.See(Numbered("d", i), T_world_doors[i], {static_cast<int>(i), static_cast<int>(i) + 1},
                                covariances[i], random));
    }
    return Graph(world.MapIds(), doors);
  }
};

// Deviations per anchor in metres and radians.
Row MakeRow(int doors, double position, double yaw, std::mt19937_64& random) {
  Row row{{{Pose2()}}, {}, {}};
  for (int i = 0; i < doors; ++i) {
    const Pose2 into{Uniform(4, 12, random), Uniform(-5, 5, random), Uniform(-1.5, 1.5, random)};
    row.world.T_world_maps.push_back(row.world.T_world_maps.back() * into);
    row.T_world_doors.push_back(row.world.T_world_maps.back() *
                                Pose2{Uniform(-2, 2, random), Uniform(-2, 2, random), Uniform(-3, 3, random)});
    const double scale = std::pow(2.0, i % 3);  // the hops differ
    row.covariances.push_back(
        {RandomCovariance(scale * position, yaw, random), RandomCovariance(position, scale * yaw, random)});
  }
  return row;
}

TEST(GlobalPoseTest, TheRootIsTheWorld) {
  const Eigen::Matrix3d S = Eigen::Vector3d(0.1, 0.2, 0.3).asDiagonal();
  const GlobalPose pose = Find(Graph({"a"}, {}), "a", {{1, 2, 3}, S});
  EXPECT_EQ(pose.T_world_robot.pose, (Pose2{1, 2, 3}));
  EXPECT_EQ(pose.T_world_robot.covariance, S);
  EXPECT_EQ(pose.base_map, M("a"));
  EXPECT_THAT(pose.hops, IsEmpty());
  EXPECT_FALSE(pose.solution_version.has_value());
}

TEST(GlobalPoseTest, ListsTheHopsWithTheirShares) {
  const GraphSnapshot graph =
      Graph({"a", "b", "c"}, {Joining("ab", {AnchorIn("a", {5, 0, 1}), AnchorIn("b", {1, 1, 0})}),
                              Joining("bc", {AnchorIn("b", {4, 4, 2}), AnchorIn("c", {0, 2, -1})})});
  const GlobalPose pose = Find(graph, "c", {{3, 2, 1}, DefaultTransformCovariance()});
  ASSERT_THAT(pose.hops, SizeIs(2));
  EXPECT_EQ(pose.hops[0].link_point, testing::L("ab"));
  EXPECT_EQ(pose.hops[1].from, M("b"));
  EXPECT_EQ(pose.hops[1].to, M("c"));
  EXPECT_EQ(pose.graph_version, 1);
  EXPECT_THAT(pose.T_world_robot.pose,
              PoseNear(pose.hops[0].T_from_to.pose * pose.hops[1].T_from_to.pose * Pose2{3, 2, 1}, 1e-12, 1e-12));
  EXPECT_TRUE(SumOfShares(pose).isApprox(pose.T_world_robot.covariance, 1e-12));
  const PoseWithCovariance composed =
      Compose(Compose(pose.hops[0].T_from_to, pose.hops[1].T_from_to), {{3, 2, 1}, DefaultTransformCovariance()});
  EXPECT_TRUE(composed.covariance.isApprox(pose.T_world_robot.covariance, 1e-12));
}

TEST(GlobalPoseTest, ADisconnectedMapHasNoPoseAndAnUnknownMapIsAnError) {
  const WorldPoses poses(Graph({"a", "island"}, {}));
  const auto island = poses.Find(M("island"));
  ASSERT_OK(island);
  EXPECT_FALSE(island->has_value());
  EXPECT_STATUS(poses.Find(M("nowhere")), absl::StatusCode::kNotFound, HasSubstr("nowhere"));
}

TEST(GlobalPoseTest, RepeatedQueriesGiveTheSameCovariance) {
  std::mt19937_64 random(5);
  GraphSnapshot graph = MakeRow(4, 0.02, 0.01, random).Seen(random);
  const Eigen::Matrix3d first = Find(graph, "m4").T_world_robot.covariance;
  for (int rebuild = 0; rebuild < 5; ++rebuild) {
    graph = Graph({Numbered("x", rebuild)}, {*graph.FindLinkPoint(testing::L("d1"))}, graph);
    EXPECT_EQ(Find(graph, "m4").T_world_robot.covariance, first);
  }
}

TEST(GlobalPoseTest, TheRobotsPoseIsGivenInTheMapsFrame) {
  const GraphSnapshot graph = Graph({"a", "b"}, {Joining("ab", {AnchorIn("a", {5, 0, 0}), AnchorIn("b", {0, 0, 0})})});
  EXPECT_THAT(Find(graph, "b", {{2, 1, M_PI / 2}, Eigen::Matrix3d::Zero()}).T_world_robot.pose,
              PoseNear(Pose2{7, 1, M_PI / 2}, 1e-12, 1e-12));
}

TEST(GlobalPoseTest, TheDoorNearTheRobotIsTheOneThatCounts) {
  // Two doors into a long hall, equally well known: a yaw's error grows with the way from the door.
  const GraphSnapshot graph =
      Graph({"a", "hall"}, {Joining("west", {AnchorIn("a", {0, 0, 0}), AnchorIn("hall", {0, 0, 0})}),
                            Joining("east", {AnchorIn("a", {90, 0, 0}), AnchorIn("hall", {90, 0, 0})})});
  EXPECT_EQ(Find(graph, "hall", {{5, 0, 0}, Eigen::Matrix3d::Zero()}).hops[0].link_point, testing::L("west"));
  EXPECT_EQ(Find(graph, "hall", {{85, 0, 0}, Eigen::Matrix3d::Zero()}).hops[0].link_point, testing::L("east"));
}

TEST(GlobalPoseTest, ClosedDoorsCarryPoses) {
  LinkPoint door = Joining("ab", {AnchorIn("a", {5, 0, 0}), AnchorIn("b", {0, 0, 0})});
  door.state = PassageState::kBlocked;
  EXPECT_THAT(Find(Graph({"a", "b"}, {door}), "b").hops, SizeIs(1));
}

// The covariance's elements, each relative to the deviations of its row and column.
double LargestDifference(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  const Eigen::Vector3d scale = b.diagonal().cwiseSqrt();
  return (a - b).cwiseQuotient(scale * scale.transpose()).cwiseAbs().maxCoeff();
}

TEST(GlobalPoseTest, ChainsWithDifferentNoisePerHopAgreeWithMonteCarlo) {
  std::mt19937_64 random(11);
  for (const int doors : {1, 3, 5}) {
    const Row row = MakeRow(doors, 0.03, 0.004, random);
    const MapId last(Numbered("m", doors));
    const PoseWithCovariance T_map_robot{{3, -2, 0.4}, RandomCovariance(0.05, 0.01, random)};
    // What the chain makes of exact anchors with their covariances.
    std::vector<LinkPoint> exact;
    for (std::size_t i = 0; i < row.T_world_doors.size(); ++i) {
      std::vector<Anchor> anchors;
      for (std::size_t side = 0; side < 2; ++side) {
        anchors.push_back(AnchorIn(Numbered("m", i + side),
                                   Between(row.world.T_world_maps[i + side], row.T_world_doors[i]),
                                   row.covariances[i][side]));
      }
      exact.push_back(Joining(Numbered("d", i), anchors));
    }
    const GlobalPose predicted = Find(Graph(row.world.MapIds(), exact), last.value(), T_map_robot);
    ASSERT_THAT(predicted.hops, SizeIs(static_cast<std::size_t>(doors)));

    const Pose2 truth = predicted.T_world_robot.pose;
    const Eigen::Matrix2d S_inverse = predicted.T_world_robot.covariance.topLeftCorner<2, 2>().inverse();
    Eigen::Matrix3d sampled = Eigen::Matrix3d::Zero();
    constexpr int kSamples = 100000;
    int inside = 0;
    for (int sample = 0; sample < kSamples; ++sample) {
      Pose2 pose;
      for (const LinkPoint& door : exact) {
        const Pose2 A = Draw({door.anchors[0].T_map_place, door.anchors[0].covariance}, random);
        const Pose2 B = Draw({door.anchors[1].T_map_place, door.anchors[1].covariance}, random);
        pose = pose * A * Inverse(B);
      }
      pose = pose * Draw(T_map_robot, random);
      const Eigen::Vector3d d(pose.x - truth.x, pose.y - truth.y, WrapAngle(pose.yaw - truth.yaw));
      sampled += d * d.transpose() / kSamples;
      if (d.head<2>().dot(S_inverse * d.head<2>()) <= kChiSquared2Dof95) ++inside;
    }
    EXPECT_LT(LargestDifference(sampled, predicted.T_world_robot.covariance), 0.03) << doors;
    EXPECT_GT(inside, 0.94 * kSamples) << doors;
    EXPECT_LT(inside, 0.96 * kSamples) << doors;
  }
}

TEST(GlobalPoseTest, IsConsistentOverRandomGraphs) {
  // The normalised estimation error squared has the mean 3, and over N runs the variance 6 / N: four deviations.
  std::mt19937_64 random(21);
  constexpr int kGraphs = 1000;
  double sum = 0.0;
  double sum_optimised = 0.0;
  for (int i = 0; i < kGraphs; ++i) {
    const int maps = 4 + static_cast<int>(random() % 5);
    const World world = testing::RandomWorld(maps, 15.0, random);
    std::vector<LinkPoint> doors;
    for (int b = 1; b < maps + 3; ++b) {
      const int to = b < maps ? b : static_cast<int>(random() % static_cast<std::uint64_t>(maps));
      const int from = b < maps ? static_cast<int>(random() % static_cast<std::uint64_t>(b)) : (to + 1) % maps;
      doors.push_back(world.See(
          Numbered("d", b), {Uniform(0, 15, random), Uniform(0, 15, random), Uniform(-3, 3, random)}, {from, to},
          {RandomCovariance(0.02, 0.002, random), RandomCovariance(0.01, 0.004, random)}, random));
    }
    const PoseWithCovariance noise{{2, 1, 0.5}, RandomCovariance(0.03, 0.01, random)};
    const PoseWithCovariance T_map_robot{Draw(noise, random), noise.covariance};
    const Pose2 truth = world.T_world_maps.back() * noise.pose;
    const auto nees = [&truth](const PoseWithCovariance& estimate) {
      const Eigen::Vector3d d(estimate.pose.x - truth.x, estimate.pose.y - truth.y,
                              WrapAngle(estimate.pose.yaw - truth.yaw));
      return d.dot(estimate.covariance.inverse() * d);
    };
    const std::string last = Numbered("m", maps - 1);
    GraphSnapshot graph = Graph(world.MapIds(), doors);
    sum += nees(Find(graph, last, T_map_robot).T_world_robot);
    // No gate: switching off what chance put outside of it would make the rest look better than it is.
    ASSERT_OK_AND_ASSIGN(SolvedGraph solution, OptimizeGraph(graph, {.gate_probability = 1.0 - 1e-9}));
    graph = Apply(graph, ChangesOf(graph, std::move(solution), 2)).value();
    sum_optimised += nees(Find(graph, last, T_map_robot).T_world_robot);
  }
  const double band = 4.0 * std::sqrt(6.0 / kGraphs);
  EXPECT_NEAR(sum / kGraphs, 3.0, band);
  EXPECT_NEAR(sum_optimised / kGraphs, 3.0, band);
}

TEST(GlobalPoseTest, OptimisingATreeChangesNothing) {
  std::mt19937_64 random(8);
  const GraphSnapshot graph = MakeRow(5, 0.02, 0.005, random).Seen(random);
  ASSERT_OK_AND_ASSIGN(SolvedGraph solution, OptimizeGraph(graph));
  const GraphSnapshot optimised = Apply(graph, ChangesOf(graph, std::move(solution), 2)).value();
  for (int i = 0; i <= 5; ++i) {
    const GlobalPose before = Find(graph, Numbered("m", i));
    const GlobalPose after = Find(optimised, Numbered("m", i));
    EXPECT_THAT(after.hops, IsEmpty());
    EXPECT_EQ(after.solution_version, 1);
    EXPECT_THAT(after.T_world_robot.pose, PoseNear(before.T_world_robot.pose, 1e-6, 1e-7));
    if (i == 0) continue;
    EXPECT_LT(LargestDifference(after.T_world_robot.covariance, before.T_world_robot.covariance), 1e-3) << i;
  }
}

TEST(GlobalPoseTest, MapsMadeSinceTheSolutionAreChainedFromASolvedOne) {
  std::mt19937_64 random(9);
  GraphSnapshot graph = MakeRow(3, 0.02, 0.005, random).Seen(random);
  ASSERT_OK_AND_ASSIGN(SolvedGraph solution, OptimizeGraph(graph));
  graph = Apply(graph, ChangesOf(graph, std::move(solution), 2)).value();
  graph = Graph({"new"}, {Joining("n", {AnchorIn("m3", {1, 2, 0.3}), AnchorIn("new", {4, 5, -0.2})})}, graph);
  const GlobalPose pose = Find(graph, "new");
  EXPECT_EQ(pose.base_map, M("m3"));
  EXPECT_EQ(pose.solution_version, 1);
  EXPECT_THAT(pose.hops, SizeIs(1));
  EXPECT_TRUE(SumOfShares(pose).isApprox(pose.T_world_robot.covariance, 1e-12));
  EXPECT_THAT(pose.T_world_robot.pose,
              PoseNear(pose.T_world_base.pose * Pose2{1, 2, 0.3} * Inverse(Pose2{4, 5, -0.2}), 1e-12, 1e-12));
  EXPECT_GT(pose.base_share.trace(), 0.0);
}

TEST(TransformTest, PosesGoFromMapToMapAndBack) {
  std::mt19937_64 random(10);
  const GraphSnapshot graph = MakeRow(3, 0.02, 0.005, random).Seen(random);
  ASSERT_OK_AND_ASSIGN(const std::optional<MapTransform> there, FindTransform(graph, M("m1"), M("m3")));
  ASSERT_OK_AND_ASSIGN(const std::optional<MapTransform> back, FindTransform(graph, M("m3"), M("m1")));
  ASSERT_TRUE(there.has_value() && back.has_value());
  EXPECT_THAT(there->T_a_b.pose * back->T_a_b.pose, PoseNear(Pose2{}, 1e-12, 1e-12));
  EXPECT_TRUE(Inverse(there->T_a_b).covariance.isApprox(back->T_a_b.covariance, 1e-9));
  const std::vector<PoseWithCovariance> poses = {{{1, 2, 3}, DefaultTransformCovariance()}, {{-1, 0, 0}, {}}};
  const std::vector<PoseWithCovariance> moved = TransformPoses(*there, poses);
  ASSERT_THAT(moved, SizeIs(2));
  EXPECT_THAT(moved[0].pose, PoseNear(there->T_a_b.pose * poses[0].pose, 1e-12, 1e-12));
}

TEST(TransformTest, AgreesWithTheSolutionWhereThereIsOne) {
  std::mt19937_64 random(12);
  World world = testing::RandomWorld(4, 20.0, random);
  std::vector<LinkPoint> doors;
  const std::vector<std::vector<int>> pairs = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 2}};
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    doors.push_back(world.See(Numbered("d", i), {Uniform(0, 20, random), Uniform(0, 20, random), 0}, pairs[i],
                              {RandomCovariance(0.05, 0.01, random), RandomCovariance(0.05, 0.01, random)}, random));
  }
  GraphSnapshot graph = Graph(world.MapIds(), doors);
  ASSERT_OK_AND_ASSIGN(SolvedGraph solution, OptimizeGraph(graph));
  graph = Apply(graph, ChangesOf(graph, std::move(solution), 2)).value();
  ASSERT_OK_AND_ASSIGN(const std::optional<MapTransform> T_1_3, FindTransform(graph, M("m1"), M("m3")));
  EXPECT_EQ(T_1_3->solution_version, 1);
  EXPECT_THAT(Find(graph, "m1").T_world_robot.pose * T_1_3->T_a_b.pose,
              PoseNear(Find(graph, "m3").T_world_robot.pose, 1e-9, 1e-9));
}

TEST(TransformTest, ManyAreFoundWithOneSearch) {
  std::mt19937_64 random(13);
  World world = testing::RandomWorld(8, 40.0, random);
  std::vector<LinkPoint> doors;
  for (std::size_t i = 0; i < 14; ++i) {
    const int a = static_cast<int>(random() % 7);  // m7 stays alone
    const int b = (a + 1 + static_cast<int>(random() % 6)) % 7;
    doors.push_back(world.See(Numbered("d", i), {Uniform(0, 40, random), Uniform(0, 40, random), 1}, {a, b},
                              {RandomCovariance(0.05, 0.01, random), RandomCovariance(0.05, 0.01, random)}, random));
  }
  const GraphSnapshot graph = Graph(world.MapIds(), doors);
  ASSERT_OK_AND_ASSIGN(TransformsTo to_m2, TransformsTo::Make(graph, M("m2")));
  std::vector<std::string> asked = world.MapIds();
  // Again, by the search that serves all.
  for (const std::string& map : world.MapIds()) asked.push_back(map);
  for (const std::string& map : asked) {
    ASSERT_OK_AND_ASSIGN(const std::optional<MapTransform> expected, FindTransform(graph, M(map), M("m2")));
    ASSERT_OK_AND_ASSIGN(const std::optional<MapTransform> found, to_m2.Find(M(map)));
    ASSERT_EQ(found.has_value(), expected.has_value()) << map;
    EXPECT_EQ(found.has_value(), map != "m7");
    if (!found.has_value()) continue;
    EXPECT_THAT(found->T_a_b.pose, PoseNear(expected->T_a_b.pose, 1e-12, 1e-12)) << map;
    EXPECT_LT((found->T_a_b.covariance - expected->T_a_b.covariance).norm(), 1e-12) << map;
    EXPECT_EQ(found->hops.size(), expected->hops.size());
  }
  // Those that were said to be asked for come from a search that ends early; others are found all the same.
  for (int i = 0; i < 20; ++i) {
    ASSERT_OK_AND_ASSIGN(TransformsTo prepared, TransformsTo::Make(graph, M("m2")));
    std::vector<MapId> said;
    for (const std::string& map : world.MapIds()) {
      if (random() % 3 == 0) said.push_back(M(map));
    }
    ASSERT_OK(prepared.Expect(said));
    for (const std::string& map : asked) {
      ASSERT_OK_AND_ASSIGN(const std::optional<MapTransform> expected, FindTransform(graph, M(map), M("m2")));
      ASSERT_OK_AND_ASSIGN(const std::optional<MapTransform> found, prepared.Find(M(map)));
      ASSERT_EQ(found.has_value(), expected.has_value()) << map;
      if (!found.has_value()) continue;
      EXPECT_THAT(found->T_a_b.pose, PoseNear(expected->T_a_b.pose, 1e-12, 1e-12)) << map;
      EXPECT_LT((found->T_a_b.covariance - expected->T_a_b.covariance).norm(), 1e-12) << map;
    }
    EXPECT_STATUS(prepared.Expect({M("x")}), absl::StatusCode::kNotFound, HasSubstr("x"));
  }
  EXPECT_STATUS(TransformsTo::Make(graph, M("x")), absl::StatusCode::kNotFound, HasSubstr("x"));
  EXPECT_STATUS(to_m2.Find(M("x")), absl::StatusCode::kNotFound, HasSubstr("x"));
}

TEST(TransformTest, NoWayIsAnAnswer) {
  const auto none = FindTransform(Graph({"a", "b"}, {}), M("a"), M("b"));
  ASSERT_OK(none);
  EXPECT_FALSE(none->has_value());
  EXPECT_STATUS(FindTransform(Graph({"a"}, {}), M("a"), M("x")), absl::StatusCode::kNotFound, HasSubstr("x"));
}

}  // namespace
}  // namespace enfilade::graph
