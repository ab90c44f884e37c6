// SPDX-License-Identifier: Apache-2.0
// Properties of optimised graphs that do not depend on numbers: exactness, symmetry and change of frames.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/graph/global_pose.h"
#include "core/graph/graph_optimization.h"
#include "core/graph/validate_link_point.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/graph/scene.h"

namespace enfilade::graph {
namespace {

using testing::AnchorIn;
using testing::Graph;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::Joining;
using testing::L;
using testing::M;
using testing::Numbered;
using testing::PoseNear;
using testing::RandomCovariance;
using testing::Uniform;

// A ring of maps with chords, seen with noise; `exact` leaves the noise out but not the covariances.
std::vector<LinkPoint> RingWithChords(const testing::World& world, bool exact, std::mt19937_64& random) {
  const auto n = static_cast<int>(world.T_world_maps.size());
  std::vector<LinkPoint> links;
  for (int i = 0; i < n + 3; ++i) {
    const int a = i % n;
    const int b = i < n ? (i + 1) % n : (a + n / 2) % n;
    const Pose2 place{Uniform(0, 20, random), Uniform(0, 20, random), Uniform(-3, 3, random)};
    LinkPoint link = world.See(Numbered("l", i), place, {a, b},
                               {RandomCovariance(0.03, 0.01, random), RandomCovariance(0.03, 0.01, random)}, random);
    if (exact) {
      for (std::size_t k = 0; k < 2; ++k) {
        link.anchors[k].T_map_place = Between(world.T_world_maps[static_cast<std::size_t>(k == 0 ? a : b)], place);
      }
    }
    links.push_back(link);
  }
  return links;
}

class OptimizationSeeds : public ::testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Graphs, OptimizationSeeds, ::testing::Range(1U, 9U));

TEST_P(OptimizationSeeds, ExactAnchorsGiveTheTruth) {
  std::mt19937_64 random(GetParam());
  const testing::World world = testing::RandomWorld(8, 20.0, random);
  const GraphSnapshot graph = Graph(world.MapIds(), RingWithChords(world, true, random));
  ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(graph));
  EXPECT_TRUE(solution.converged);
  EXPECT_THAT(solution.switched_off, IsEmpty());
  EXPECT_NEAR(solution.chi2_after, 0.0, 1e-6);
  EXPECT_EQ(solution.degrees_of_freedom, 3 * 11 - 3 * 7);
  for (std::size_t i = 0; i < world.T_world_maps.size(); ++i) {
    EXPECT_THAT(solution.map_poses.at(M(Numbered("m", i))).pose, PoseNear(world.T_world_maps[i], 1e-5, 1e-6));
  }
}

TEST_P(OptimizationSeeds, NamesAndOrderDoNotMatter) {
  std::mt19937_64 random(GetParam() + 100);
  const testing::World world = testing::RandomWorld(7, 20.0, random);
  const std::vector<LinkPoint> links = RingWithChords(world, false, random);
  ASSERT_OK_AND_ASSIGN(const SolvedGraph solution, OptimizeGraph(Graph(world.MapIds(), links)));

  // Map i becomes "z<9 - i>", link point i "x<77 - i>"; the root stays first.
  const auto renamed_map = [](const MapId& map) { return Numbered("z", 9 - std::stoi(map.value().substr(1))); };
  std::vector<std::string> maps;
  for (const std::string& map : world.MapIds()) maps.push_back(renamed_map(M(map)));
  std::reverse(maps.begin() + 1, maps.end());
  std::vector<LinkPoint> renamed;
  for (std::size_t i = 0; i < links.size(); ++i) {
    std::vector<Anchor> anchors;
    for (const Anchor& anchor : links[i].anchors) {
      anchors.push_back(AnchorIn(renamed_map(anchor.map), anchor.T_map_place, anchor.covariance));
    }
    renamed.push_back(Joining(Numbered("x", 77 - i), anchors));
  }
  std::shuffle(renamed.begin(), renamed.end(), random);
  ASSERT_OK_AND_ASSIGN(const SolvedGraph same, OptimizeGraph(Graph(maps, renamed)));
  EXPECT_EQ(same.root, M("z9"));
  EXPECT_EQ(same.switched_off.size(), solution.switched_off.size());
  EXPECT_NEAR(same.chi2_after, solution.chi2_after, 1e-4);
  for (const auto& [map, pose] : solution.map_poses) {
    const PoseWithCovariance& other = same.map_poses.at(M(renamed_map(map)));
    EXPECT_THAT(other.pose, PoseNear(pose.pose, 1e-5, 1e-6)) << map.value();
    EXPECT_TRUE(other.covariance.isApprox(pose.covariance, 1e-3)) << map.value();
  }
}

TEST_P(OptimizationSeeds, ANewFrameOfOneMapMovesOnlyThatMap) {
  std::mt19937_64 random(GetParam() + 200);
  const testing::World world = testing::RandomWorld(6, 20.0, random);
  std::vector<LinkPoint> links = RingWithChords(world, false, random);
  ASSERT_OK_AND_ASSIGN(const SolvedGraph before, OptimizeGraph(Graph(world.MapIds(), links)));
  const Pose2 T_old_new{3.0, -2.0, 1.2};
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() << std::cos(1.2), std::sin(1.2), -std::sin(1.2), std::cos(1.2);
  for (LinkPoint& link : links) {
    for (Anchor& anchor : link.anchors) {
      if (anchor.map != M("m3")) continue;
      anchor.T_map_place = Between(T_old_new, anchor.T_map_place);
      anchor.covariance = turn * anchor.covariance * turn.transpose();
    }
  }
  ASSERT_OK_AND_ASSIGN(const SolvedGraph after, OptimizeGraph(Graph(world.MapIds(), links)));
  // The covariance of a measurement is linearised in the map's frame, so the results agree to the second order only.
  EXPECT_NEAR(after.chi2_after, before.chi2_after, 0.02 * before.chi2_after);
  for (const auto& [map, pose] : before.map_poses) {
    const Pose2 expected = map == M("m3") ? pose.pose * T_old_new : pose.pose;
    EXPECT_THAT(after.map_poses.at(map).pose, PoseNear(expected, 3e-3, 3e-4)) << map.value();
  }
}

TEST_P(OptimizationSeeds, MoreLinkPointsNeverMakeMapsLessCertain) {
  std::mt19937_64 random(GetParam() + 300);
  const testing::World world = testing::RandomWorld(8, 20.0, random);
  const std::vector<LinkPoint> links = RingWithChords(world, true, random);
  ASSERT_OK_AND_ASSIGN(const SolvedGraph more, OptimizeGraph(Graph(world.MapIds(), links)));
  ASSERT_OK_AND_ASSIGN(const SolvedGraph fewer,
                       OptimizeGraph(Graph(world.MapIds(), {links.begin(), links.begin() + 8})));
  for (const auto& [map, pose] : more.map_poses) {
    const PoseWithCovariance& other = fewer.map_poses.at(map);
    EXPECT_LE(pose.covariance.trace(), other.covariance.trace() + 1e-9) << map.value();
    EXPECT_LE(pose.covariance.determinant(), other.covariance.determinant() * (1.0 + 1e-6) + 1e-18) << map.value();
  }
}

TEST(ChangesOfSolutions, SwitchLinkPointsOffAndOnAgain) {
  const LinkPoint good = Joining("good", {AnchorIn("a", {}), AnchorIn("b", {})});
  LinkPoint off = Joining("off", {AnchorIn("a", {}), AnchorIn("b", {})});
  off.use = LinkPointUse::kSwitchedOff;
  LinkPoint suspended = Joining("suspended", {AnchorIn("a", {}), AnchorIn("b", {})});
  suspended.use = LinkPointUse::kSuspended;
  const GraphSnapshot graph = Graph({"a", "b"}, {good, off, suspended});
  SolvedGraph solution{.graph_version = 1, .root = M("a")};
  solution.switched_off = {{.link_point = L("good"), .chi2 = 99.0, .gate = 16.0}, {.link_point = L("suspended")}};
  const SnapshotChanges changes = ChangesOf(graph, solution, 7);
  EXPECT_EQ(changes.version, 7);
  ASSERT_EQ(changes.link_points.size(), 2U) << "a suspended link point stays suspended";
  EXPECT_EQ(changes.link_points[0].id, L("good"));
  EXPECT_EQ(changes.link_points[0].use, LinkPointUse::kSwitchedOff);
  EXPECT_EQ(changes.link_points[0].graph_version, 7);
  EXPECT_EQ(changes.link_points[1].id, L("off"));
  EXPECT_EQ(changes.link_points[1].use, LinkPointUse::kUsed);
  ASSERT_NE(changes.solution, nullptr);
  EXPECT_EQ(changes.solution->graph_version, 1);
}

TEST(GraphOptimizationOptions, AreChecked) {
  const GraphSnapshot graph = Graph({"a"}, {});
  const std::vector<std::pair<GraphOptimizationOptions, const char*>> table = {
      {{.gate_probability = 0.0}, "gate_probability is 0"}, {{.gate_probability = std::nan("")}, "gate_probability"},
      {{.kernel_width = -1.0}, "kernel_width is -1"},       {{.kernel_width = INFINITY}, "kernel_width"},
      {{.position_floor_m = 0.0}, "position_floor_m"},      {{.yaw_floor_rad = 0.0}, "yaw_floor_rad"},
  };
  for (const auto& [options, message] : table) {
    EXPECT_STATUS(OptimizeGraph(graph, options), absl::StatusCode::kInvalidArgument, HasSubstr(message));
  }
}

TEST(ValidateLinkPoint, NamesTheFault) {
  const auto status = [](std::vector<Anchor> anchors) { return ValidateLinkPoint(Joining("x", std::move(anchors))); };
  constexpr auto kBad = absl::StatusCode::kInvalidArgument;
  EXPECT_OK(status({AnchorIn("a", {1, 2, 3})}));
  EXPECT_OK(status({AnchorIn("a", {}), AnchorIn("b", {}), AnchorIn("c", {}, Eigen::Matrix3d::Zero())}));
  EXPECT_STATUS(ValidateLinkPoint(Joining("", {AnchorIn("a", {})})), kBad, HasSubstr("no id"));
  EXPECT_STATUS(status({}), kBad, HasSubstr("x has no anchor"));
  EXPECT_STATUS(status({AnchorIn("a", {}), AnchorIn("b", {}), AnchorIn("a", {})}), kBad,
                HasSubstr("two anchors in map a"));
  EXPECT_STATUS(status({AnchorIn("a", {}), AnchorIn("b", {0, INFINITY, 0})}), kBad, HasSubstr("map b: the pose"));
  EXPECT_STATUS(status({AnchorIn("a", {}, -Eigen::Matrix3d::Identity())}), kBad, HasSubstr("positive semi-definite"));
}

}  // namespace
}  // namespace enfilade::graph
