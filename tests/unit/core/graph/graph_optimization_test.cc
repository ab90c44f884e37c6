// SPDX-License-Identifier: Apache-2.0
#include "core/graph/graph_optimization.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "core/geometry/covariance.h"
#include "core/graph/chi_squared.h"
#include "core/graph/global_pose.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/graph/scene.h"

namespace enfilade::graph {
namespace {

using testing::AnchorIn;
using ::testing::ElementsAre;
using testing::Graph;
using ::testing::IsEmpty;
using testing::Joining;
using testing::L;
using testing::M;
using testing::Numbered;
using testing::PoseNear;
using testing::RandomCovariance;
using ::testing::SizeIs;
using testing::Uniform;
using testing::World;

// Rooms around a yard: maps 0 to n - 1 in a ring, a door between neighbours.
World Ring(int maps, double radius) {
  World world;
  for (int i = 0; i < maps; ++i) {
    const double angle = 2.0 * M_PI * i / maps;
    world.T_world_maps.push_back({radius * std::cos(angle), radius * std::sin(angle), WrapAngle(angle)});
  }
  const Pose2 first = world.T_world_maps[0];
  for (Pose2& T_world_map : world.T_world_maps) T_world_map = Between(first, T_world_map);
  return world;
}

Pose2 DoorBetween(const World& world, int a, int b) {
  return Interpolate(world.T_world_maps[static_cast<std::size_t>(a)], world.T_world_maps[static_cast<std::size_t>(b)],
                     0.5);
}

std::vector<LinkPoint> RingDoors(const World& world, double position, double yaw, std::mt19937_64& random) {
  std::vector<LinkPoint> doors;
  const int maps = static_cast<int>(world.T_world_maps.size());
  for (int i = 0; i < maps; ++i) {
    const int next = (i + 1) % maps;
    doors.push_back(world.See(Numbered("d", i), DoorBetween(world, i, next), {i, next},
                              {RandomCovariance(position, yaw, random), RandomCovariance(position, yaw, random)},
                              random));
  }
  return doors;
}

GraphSnapshot Optimised(const GraphSnapshot& graph, const GraphOptimizationOptions& options = {}) {
  return Apply(graph, ChangesOf(graph, OptimizeGraph(graph, options).value(), graph.version() + 1)).value();
}

// Root mean square of the maps' position errors.
double Error(const GraphSnapshot& graph, const World& world) {
  const WorldPoses poses(graph);
  double sum = 0.0;
  for (std::size_t i = 0; i < world.T_world_maps.size(); ++i) {
    const Pose2 pose = poses.Find(M(Numbered("m", i))).value().value().T_world_robot.pose;
    sum += (pose.translation() - world.T_world_maps[i].translation()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(world.T_world_maps.size()));
}

TEST(ChiSquaredTest, QuantilesAreThoseOfTheTables) {
  EXPECT_NEAR(ChiSquaredQuantile(0.95, 2), 5.991, 5e-4);
  EXPECT_NEAR(ChiSquaredQuantile(0.999, 3), 16.266, 5e-4);
  EXPECT_NEAR(ChiSquaredQuantile(0.99, 6), 16.812, 5e-4);
  EXPECT_NEAR(ChiSquaredQuantile(0.5, 1), 0.4549, 5e-5);
}

TEST(GraphOptimizationTest, ExactAnchorsGiveTheExactWorld) {
  std::mt19937_64 random(1);
  const World world = Ring(6, 10.0);
  std::vector<LinkPoint> doors;
  for (int i = 0; i < 6; ++i) {
    const Pose2 place = DoorBetween(world, i, (i + 1) % 6);
    doors.push_back(Joining(
        Numbered("d", i),
        {AnchorIn(Numbered("m", i), Between(world.T_world_maps[static_cast<std::size_t>(i)], place),
                  Eigen::Matrix3d::Zero()),
         AnchorIn(Numbered("m", (i + 1) % 6), Between(world.T_world_maps[static_cast<std::size_t>((i + 1) % 6)], place),
                  Eigen::Matrix3d::Zero())}));
  }
  const GraphSnapshot graph = Graph(world.MapIds(), doors);
  ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(graph));
  EXPECT_TRUE(solution.converged);
  EXPECT_THAT(solution.switched_off, IsEmpty());
  EXPECT_LT(solution.chi2_after, 1e-9);
  EXPECT_LT(Error(Optimised(graph), world), 1e-6);
}

TEST(GraphOptimizationTest, AClosureTakesDriftOutOfLoops) {
  // Mapping bends every room the same way and sees doors with noise, so that the chain drifts; the ring's closure says
  // by how much.
  std::mt19937_64 random(2);
  std::vector<double> factors;
  int better = 0;
  for (int loop = 0; loop < 100; ++loop) {
    const World world = Ring(8 + static_cast<int>(random() % 13), Uniform(15, 40, random));
    std::vector<LinkPoint> doors = RingDoors(world, 0.05, 0.03, random);
    const double bend = Uniform(0.01, 0.04, random) * (loop % 2 == 0 ? 1.0 : -1.0);  // rad per room
    for (LinkPoint& door : doors) door.anchors[0].T_map_place = Pose2{0, 0, bend} * door.anchors[0].T_map_place;
    // Before the closure there is only the chain from the first to the last map.
    const GraphSnapshot open = Graph(world.MapIds(), {doors.begin(), doors.end() - 1});
    const GraphSnapshot closed = Optimised(Graph({}, {doors.back()}, open));
    const double before = Error(open, world);
    const double after = Error(closed, world);
    if (after < before) ++better;
    factors.push_back(before / after);
  }
  std::nth_element(factors.begin(), factors.begin() + 50, factors.end());
  std::cout << "better in " << better << " of 100, median factor " << factors[50] << "\n";
  RecordProperty("median_factor", std::to_string(factors[50]));
  EXPECT_GE(better, 95);
}

TEST(GraphOptimizationTest, AFalseClosureAmongFiveGoodOnesIsSwitchedOff) {
  std::mt19937_64 random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const World world = Ring(12, 20.0);
    std::vector<LinkPoint> doors = RingDoors(world, 0.02, 0.01, random);
    for (int i = 0; i < 5; ++i) {
      doors.push_back(world.See(Numbered("good", i), DoorBetween(world, i, i + 6), {i, i + 6},
                                {RandomCovariance(0.02, 0.01, random), RandomCovariance(0.02, 0.01, random)}, random));
    }
    LinkPoint wrong = world.See("wrong", DoorBetween(world, 2, 9), {2, 9},
                                {RandomCovariance(0.02, 0.01, random), RandomCovariance(0.02, 0.01, random)}, random);
    wrong.anchors[1].T_map_place =
        wrong.anchors[1].T_map_place * Pose2{Uniform(1, 8, random), Uniform(-5, 5, random), Uniform(-3, 3, random)};
    doors.push_back(wrong);
    const GraphSnapshot graph = Graph(world.MapIds(), doors);
    ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(graph, {.gate_probability = 0.99999}));
    ASSERT_THAT(solution.switched_off, SizeIs(1)) << trial;
    EXPECT_EQ(solution.switched_off[0].link_point, L("wrong"));
    EXPECT_GT(solution.switched_off[0].chi2, solution.switched_off[0].gate);
    const GraphSnapshot optimised = Optimised(graph, {.gate_probability = 0.99999});
    EXPECT_EQ(optimised.FindLinkPoint(L("wrong"))->use, LinkPointUse::kSwitchedOff);
    doors.pop_back();
    const GraphSnapshot never = Optimised(Graph(world.MapIds(), doors), {.gate_probability = 0.99999});
    for (const auto& [map, pose] : never.solution()->map_poses) {
      EXPECT_THAT(optimised.solution()->map_poses.at(map).pose, PoseNear(pose.pose, 1e-6, 1e-7));
    }
    // What was mended is used again.
    LinkPoint mended = world.See("wrong", DoorBetween(world, 2, 9), {2, 9},
                                 {RandomCovariance(0.02, 0.01, random), RandomCovariance(0.02, 0.01, random)}, random);
    mended.use = LinkPointUse::kSwitchedOff;
    const GraphSnapshot again = Optimised(Graph({}, {mended}, optimised), {.gate_probability = 0.99999});
    EXPECT_EQ(again.FindLinkPoint(L("wrong"))->use, LinkPointUse::kUsed);
  }
}

TEST(GraphOptimizationTest, TheOnlyConnectionIsNeverSwitchedOff) {
  // Two doors between the same maps that cannot both be right.
  const GraphSnapshot graph = Graph({"a", "b"}, {Joining("x", {AnchorIn("a", {0, 0, 0}), AnchorIn("b", {0, 0, 0})}),
                                                 Joining("y", {AnchorIn("a", {5, 0, 0}), AnchorIn("b", {50, 0, 0})})});
  ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(graph));
  EXPECT_THAT(solution.switched_off, SizeIs(1));
  EXPECT_THAT(solution.map_poses, SizeIs(2));
}

TEST(GraphOptimizationTest, ALinkPointThatCannotBeSolvedWithIsSwitchedOffAndNamed) {
  LinkPoint broken = Joining("w", {AnchorIn("b", {1, 0, 0}), AnchorIn("c", {})});
  broken.anchors[0].covariance = 1e300 * Eigen::Matrix3d::Identity();
  const GraphSnapshot graph =
      Graph({"a", "b", "c"}, {Joining("x", {AnchorIn("a", {3, 0, 0}), AnchorIn("b", {})}), broken});
  ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(graph));
  EXPECT_THAT(solution.map_poses, SizeIs(2));
  EXPECT_THAT(solution.map_poses.at(M("b")).pose, PoseNear(Pose2{3, 0, 0}, 1e-6, 1e-6));
  EXPECT_THAT(solution.disconnected, ElementsAre(M("c")));
  EXPECT_THAT(solution.switched_off, ElementsAre(SwitchedOff{.link_point = L("w")}));
}

TEST(GraphOptimizationTest, TheLargestPermittedCovarianceIsSolvedBesideExactOnes) {
  LinkPoint vague = Joining("w", {AnchorIn("b", {1, 0, 0}), AnchorIn("c", {})});
  vague.anchors[0].covariance = kMaxVariance * Eigen::Matrix3d::Identity();
  LinkPoint exact = Joining("x", {AnchorIn("a", {3, 0, 0}), AnchorIn("b", {})});
  for (Anchor& anchor : exact.anchors) anchor.covariance.setZero();
  const GraphSnapshot graph = Graph({"a", "b", "c"}, {exact, vague});
  ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(graph));
  EXPECT_THAT(solution.map_poses.at(M("c")).pose, PoseNear(Pose2{4, 0, 0}, 1e-3, 1e-3));
  EXPECT_THAT(solution.switched_off, IsEmpty());
}

TEST(GraphOptimizationTest, ReportsDisconnectedMaps) {
  const GraphSnapshot graph = Graph({"a", "b", "c", "d"}, {Joining("x", {AnchorIn("a", {}), AnchorIn("b", {})}),
                                                           Joining("y", {AnchorIn("c", {}), AnchorIn("d", {})})});
  ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(graph));
  EXPECT_THAT(solution.disconnected, ElementsAre(M("c"), M("d")));
  EXPECT_THAT(solution.map_poses, SizeIs(2));
  EXPECT_TRUE(solution.map_poses.at(M("a")).covariance.isZero());
}

TEST(GraphOptimizationTest, ASuspendedClosureTakesNoPartAndMayBeResumed) {
  std::mt19937_64 random(4);
  const World world = Ring(6, 10.0);
  std::vector<LinkPoint> doors = RingDoors(world, 0.05, 0.02, random);
  const GraphSnapshot with = Optimised(Graph(world.MapIds(), doors));
  doors.back().use = LinkPointUse::kSuspended;
  const GraphSnapshot without = Optimised(Graph({}, {doors.back()}, with));
  EXPECT_EQ(without.FindLinkPoint(doors.back().id)->use, LinkPointUse::kSuspended);
  // A tree: as the chain has it.
  const GraphSnapshot tree = Graph(world.MapIds(), {doors.begin(), doors.end() - 1});
  EXPECT_THAT(without.solution()->map_poses.at(M("m5")).pose,
              PoseNear(WorldPoses(tree).Find(M("m5")).value().value().T_world_robot.pose, 1e-5, 1e-6));
  doors.back().use = LinkPointUse::kUsed;
  const GraphSnapshot resumed = Optimised(Graph({}, {doors.back()}, without));
  EXPECT_THAT(resumed.solution()->map_poses.at(M("m5")).pose,
              PoseNear(with.solution()->map_poses.at(M("m5")).pose, 1e-6, 1e-7));
}

TEST(GraphOptimizationTest, ALiftIsOnePlaceNotThreePairs) {
  // One lift seen from three floors: nothing to even out, and as uncertain as its anchors say, not less.
  std::mt19937_64 random(5);
  const World world = testing::RandomWorld(3, 5.0, random);
  const Eigen::Matrix3d S = RandomCovariance(0.05, 0.02, random);
  const LinkPoint lift = world.See("lift", {2, 3, 1}, {0, 1, 2}, {S, S, S}, random);
  const GraphSnapshot graph = Graph(world.MapIds(), {lift});
  ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(graph));
  EXPECT_LT(solution.chi2_after, 1e-6);
  EXPECT_EQ(solution.degrees_of_freedom, 0);
  const GlobalPose chained = WorldPoses(graph).Find(M("m2")).value().value();
  const PoseWithCovariance& solved = solution.map_poses.at(M("m2"));
  EXPECT_THAT(solved.pose, PoseNear(chained.T_world_robot.pose, 1e-5, 1e-6));
  EXPECT_TRUE(solved.covariance.isApprox(chained.T_world_robot.covariance, 1e-2));
}

TEST(GraphOptimizationTest, ALiftThatContradictsIsSwitchedOff) {
  std::mt19937_64 random(6);
  const World world = testing::RandomWorld(3, 20.0, random);
  const Eigen::Matrix3d S = RandomCovariance(0.02, 0.01, random);
  std::vector<LinkPoint> links;
  for (int i = 0; i < 4; ++i) {
    links.push_back(world.See(Numbered("lift", i), {5.0 * i, 3.0 * (i % 2), 1}, {0, 1, 2}, {S, S, S}, random));
  }
  links[2].anchors[1].T_map_place.x += 3.0;
  ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(Graph(world.MapIds(), links)));
  ASSERT_THAT(solution.switched_off, SizeIs(1));
  EXPECT_EQ(solution.switched_off[0].link_point, L("lift2"));
}

// Measurements read off drifting world poses would make all residuals zero.
TEST(GraphOptimizationTest, MeasurementsComeFromTheAnchorsNotFromWorldPoses) {
  std::mt19937_64 random(7);
  const World world = Ring(8, 15.0);
  const GraphSnapshot graph = Graph(world.MapIds(), RingDoors(world, 0.05, 0.02, random));
  ASSERT_OK_AND_ASSIGN(const SolvedGraph first, OptimizeGraph(graph));
  EXPECT_GT(first.chi2_before, first.chi2_after);
  EXPECT_GT(first.chi2_after, 0.0);
  // Solved again from the solution: the same residuals, the same poses, the same covariances.
  ASSERT_OK_AND_ASSIGN(const SolvedGraph second, OptimizeGraph(Optimised(graph)));
  EXPECT_NEAR(second.chi2_before, first.chi2_after, 1e-6);
  EXPECT_NEAR(second.chi2_after, first.chi2_after, 1e-6);
  for (const auto& [map, pose] : first.map_poses) {
    EXPECT_THAT(second.map_poses.at(map).pose, PoseNear(pose.pose, 1e-6, 1e-7));
    EXPECT_TRUE(second.map_poses.at(map).covariance.isApprox(pose.covariance, 1e-4));
  }
  // A solution that is wrong by metres is a bad start, not evidence.
  SolvedGraph wrong = first;
  for (auto& [map, pose] : wrong.map_poses) {
    if (map != graph.root()) pose.pose = Pose2{2.0, -1.0, 0.3} * pose.pose;
  }
  const GraphSnapshot drifted = Apply(graph, ChangesOf(graph, wrong, 2)).value();
  ASSERT_OK_AND_ASSIGN(const SolvedGraph third, OptimizeGraph(drifted));
  EXPECT_NEAR(third.chi2_after, first.chi2_after, 1e-6);
}

TEST(GraphOptimizationTest, TheOrientationOfALinkPointCounts) {
  const Eigen::Matrix3d loose = Eigen::Vector3d(1e-4, 1e-4, 0.01).asDiagonal();
  const Eigen::Matrix3d tight = Eigen::Vector3d(1e-4, 1e-4, 1e-6).asDiagonal();
  // Two doors at the same place of a, as far as position goes: what differs is the yaw.
  const GraphSnapshot graph =
      Graph({"a", "b"}, {Joining("x", {AnchorIn("a", {0, 0, 0.1}, loose), AnchorIn("b", {0, 0, 0}, loose)}),
                         Joining("y", {AnchorIn("a", {0, 0, 0}, tight), AnchorIn("b", {0, 0, 0}, tight)})});
  ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(graph));
  EXPECT_NEAR(solution.map_poses.at(M("b")).pose.yaw, 0.0, 1e-4);
  EXPECT_LT(solution.map_poses.at(M("b")).covariance(2, 2), 3e-6);
}

TEST(GraphOptimizationTest, FullCovariancesCount) {
  // x says that b lies somewhere on a line through (1, 0) at 45 degrees; y fixes its x coordinate.
  Eigen::Matrix3d along = Eigen::Matrix3d::Zero();
  along.topLeftCorner<2, 2>() << 1.0, 0.9999, 0.9999, 1.0;
  along(2, 2) = 1e-6;
  const Eigen::Matrix3d only_x = Eigen::Vector3d(1e-6, 1e4, 1e-6).asDiagonal();
  const Eigen::Matrix3d none = Eigen::Matrix3d::Zero();
  const GraphSnapshot graph =
      Graph({"a", "b"}, {Joining("x", {AnchorIn("a", {1, 0, 0}, along), AnchorIn("b", {0, 0, 0}, none)}),
                         Joining("y", {AnchorIn("a", {1.5, 7, 0}, only_x), AnchorIn("b", {0, 0, 0}, none)})});
  ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(graph));
  EXPECT_THAT(solution.map_poses.at(M("b")).pose, PoseNear(Pose2{1.5, 0.5, 0}, 0.01, 1e-3));
}

TEST(GraphOptimizationTest, RefusesInvalidArguments) {
  EXPECT_CODE(OptimizeGraph(GraphSnapshot()), absl::StatusCode::kFailedPrecondition);
  const GraphSnapshot graph = Graph({"a"}, {});
  EXPECT_CODE(OptimizeGraph(graph, {.gate_probability = 1.0}), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(OptimizeGraph(graph, {.kernel_width = 0.0}), absl::StatusCode::kInvalidArgument);
  ASSERT_OK_AND_ASSIGN(const SolvedGraph alone, OptimizeGraph(graph));
  EXPECT_THAT(alone.map_poses, SizeIs(1));
}

}  // namespace
}  // namespace enfilade::graph
