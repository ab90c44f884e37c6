// SPDX-License-Identifier: Apache-2.0
#include "core/slam/loops/loop_matching.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/slam/matching/scan_points.h"
#include "core/slam/submaps/robot_rays.h"
#include "tests/support/pose_matchers.h"
#include "tests/unit/core/slam/synthetic_drive.h"

namespace enfilade::slam {
namespace {

using ::testing::HasSubstr;
using testing::PoseNear;
using testing::Wall;

constexpr testing::SyntheticScanner kAllAround{.beams = 360, .field_of_view = 2.0 * M_PI};
constexpr LoopCandidate kNear{.half_width = 0.5, .half_angle = 0.15};
constexpr LoopCandidate kFar{.half_width = 4.0, .half_angle = M_PI};

struct ScannedPlace {
  explicit ScannedPlace(std::vector<Wall> of, const std::vector<Pose2>& seen_from, double range = 20.0)
      : walls(std::move(of)), grid(0.05, {}) {
    scanner.range_max = range;
    for (const Pose2& pose : seen_from) EXPECT_TRUE(grid.Insert(pose, RaysFrom(pose)).ok());
  }

  grid::ScanRays RaysFrom(const Pose2& pose) const {
    return RobotRays(testing::Scan(walls, pose, scanner, 0, 3), {.max_range = 30.0, .no_return_range = 0.0});
  }

  LoopMatch Look(const std::vector<Eigen::Vector2d>& hits, const Pose2& guess, const LoopCandidate& candidate,
                 const SlamOptions& options = {}) const {
    return MatchLoop(SearchableSubmap(grid, options.pyramid), hits, guess, candidate, options);
  }

  std::vector<Wall> walls;
  testing::SyntheticScanner scanner = kAllAround;
  SubmapGrid grid;
};

ScannedPlace RoomWithNiches() {
  return ScannedPlace(testing::WallsFromText({"############",  //
                                              "#   #      #",  //
                                              "#         ##",  //
                                              "#          #",  //
                                              "##         #",  //
                                              "#     #    #",  //
                                              "############"},
                                             1.0),
                      {{4.0, 3.0, 0.0}, {8.0, 4.0, 1.0}, {6.0, 5.0, -2.0}});
}

const Pose2 kTruth{7.0, 3.5, 0.7};

TEST(MatchLoop, FindsAndAcceptsThePlaceSeenAgain) {
  const ScannedPlace room = RoomWithNiches();
  const auto hits = room.RaysFrom(kTruth).hits;
  for (const auto& [off, candidate] :
       {std::pair{Pose2{0.3, -0.3, 0.1}, kNear}, std::pair{Pose2{2.5, -1.5, 2.0}, kFar}}) {
    const LoopMatch match = room.Look(hits, kTruth * off, candidate);
    EXPECT_TRUE(match.accepted) << match.reason;
    EXPECT_THAT(match.T_submap_node, PoseNear(kTruth, 0.02, 0.005));
    EXPECT_GT(match.score, 0.9);
    EXPECT_THAT(match.reason, HasSubstr("inlier share"));
    // No surer than a submap is straight.
    const LoopOptions options;
    EXPECT_LE(match.information(0, 0), 1.0 / (options.sigma_floor * options.sigma_floor) + 1e-6);
    EXPECT_GT(match.information(2, 2), 100.0);
  }
}

TEST(MatchLoop, RefusesAScanThatSaysTooLittle) {
  const ScannedPlace room = RoomWithNiches();
  const LoopMatch match = room.Look(Subsampled(room.RaysFrom(kTruth).hits, 20), kTruth, kNear);
  EXPECT_FALSE(match.accepted);
  EXPECT_THAT(match.reason, HasSubstr("points, fewer than 30"));
  EXPECT_TRUE(match.information.isZero());
}

TEST(MatchLoop, RefusesAnotherRoom) {
  const ScannedPlace room = RoomWithNiches();
  const ScannedPlace other(testing::WallsFromText({"#######",  //
                                                   "#  #  #",  //
                                                   "#     #",  //
                                                   "#    ##",  //
                                                   "#######"},
                                                  1.0),
                           {});
  const LoopMatch match = room.Look(other.RaysFrom({3.0, 2.0, 0.5}).hits, kTruth, kFar);
  EXPECT_FALSE(match.accepted);
  EXPECT_TRUE(match.information.isZero());
}

TEST(MatchLoop, RefusesWhatStandsWhereTheSubmapKnowsFreeSpace) {
  const ScannedPlace room = RoomWithNiches();
  auto hits = room.RaysFrom(kTruth).hits;
  // A third of the beams end in the middle of the room: not so many that the rest would not be inliers.
  for (std::size_t i = 0; i < hits.size(); i += 3) hits[i] *= 0.5;
  const LoopMatch match = room.Look(hits, kTruth, kNear);
  EXPECT_FALSE(match.accepted);
  EXPECT_THAT(match.reason, HasSubstr("lie in free space of the submap"));
}

// Two parallel walls, no end in sight: the place along them is open.
TEST(MatchLoop, RefusesAPlaceAlongABareCorridor) {
  const ScannedPlace corridor({{{-40.0, -1.0}, {40.0, -1.0}}, {{-40.0, 1.0}, {40.0, 1.0}}},
                              {{-4.0, 0.0, 0.0}, {-2.0, 0.3, 0.2}, {0.0, 0.0, 0.0}, {2.0, -0.2, 0.1}, {4.0, 0.0, 0.0}},
                              5.0);
  const LoopMatch match = corridor.Look(corridor.RaysFrom({0.5, 0.2, 0.1}).hits, {0.7, 0.1, 0.1}, kNear);
  EXPECT_FALSE(match.accepted);
  EXPECT_THAT(match.reason, HasSubstr("along the walls"));
}

// Equal niches every 2 m: only the guess can tell them apart, and it may be 4 m off.
TEST(MatchLoop, RefusesOneOfSeveralPlacesThatLookAlike) {
  const auto walls = testing::WallsFromText({"################################",  //
                                             "## ### ### ### ### ### ### ### #",  //
                                             "#                              #",  //
                                             "#                              #",  //
                                             "################################"},
                                            0.5);
  const ScannedPlace hall(walls, {{4.0, 1.0, 0.0}, {8.0, 1.0, 0.0}, {12.0, 1.0, 0.0}}, 3.0);
  const Pose2 here{8.1, 1.0, 0.0};
  const LoopMatch unsure = hall.Look(hall.RaysFrom(here).hits, here, {.half_width = 4.0, .half_angle = 0.3});
  EXPECT_FALSE(unsure.accepted);
  EXPECT_THAT(unsure.reason, HasSubstr("another place"));
  const LoopMatch sure = hall.Look(hall.RaysFrom(here).hits, here, kNear);
  EXPECT_TRUE(sure.accepted) << "within half a metre there is only one: " << sure.reason;
}

void AddOutline(std::vector<Wall>& walls, double left, double lower, double right, double upper) {
  const Eigen::Vector2d corners[] = {{left, lower}, {right, lower}, {right, upper}, {left, upper}};
  for (int i = 0; i < 4; ++i) walls.push_back({corners[i], corners[(i + 1) % 4]});
}

// A room of 3.7 m by 2.7 m in the middle of a hall, with walls that are 0.15 m thick and have no door.
std::vector<Wall> RoomInAHall() {
  std::vector<Wall> walls;
  AddOutline(walls, 0.0, 0.0, 8.0, 7.0);
  AddOutline(walls, 2.0, 2.0, 6.0, 5.0);
  AddOutline(walls, 2.15, 2.15, 5.85, 4.85);
  return walls;
}
const Pose2 kInTheRoom{4.2, 3.3, 0.4};
const Pose2 kAroundTheRoom[] = {{1.0, 1.0, 0.0}, {7.0, 1.0, 0.0}, {7.0, 3.5, 0.0}, {7.0, 6.0, 0.0}, {1.0, 6.0, 0.0}};

TEST(MatchLoop, RefusesWallsSeenFromTheirOtherSideOnly) {
  const ScannedPlace hall(RoomInAHall(), {std::begin(kAroundTheRoom), std::end(kAroundTheRoom)});
  const auto hits = hall.RaysFrom(kInTheRoom).hits;
  const Pose2 through_two_walls = Pose2{0.15, 0.15, 0.0} * kInTheRoom;
  LoopCandidate candidate{.half_width = 0.1, .half_angle = 0.1};
  const LoopMatch match = hall.Look(hits, through_two_walls, candidate);
  EXPECT_FALSE(match.accepted);
  EXPECT_THAT(match.reason, HasSubstr("other side"));
  candidate.seen_from_node = false;
  EXPECT_TRUE(hall.Look(hits, through_two_walls, candidate).accepted) << "the room fits to its walls' outside";
}

TEST(MatchLoop, IsNotPulledThroughAWall) {
  // The room's right wall was seen from the hall only, the others from inside.
  ScannedPlace hall(RoomInAHall(), {{7.0, 1.0, 0.0}, {7.0, 3.5, 0.0}, {7.0, 6.0, 0.0}});
  const Pose2 inside{3.0, 3.0, 0.0};
  grid::ScanRays rays = hall.RaysFrom(inside);
  std::erase_if(rays.hits, [&](const Eigen::Vector2d& hit) { return (inside * hit).x() > 5.8; });
  ASSERT_TRUE(hall.grid.Insert(inside, rays).ok());
  const auto hits = hall.RaysFrom(kInTheRoom).hits;
  LoopCandidate candidate = kNear;
  const auto error = [&] {
    const LoopMatch match = hall.Look(hits, Pose2{0.1, 0.0, 0.0} * kInTheRoom, candidate);
    EXPECT_TRUE(match.accepted) << match.reason;
    return (match.T_submap_node.translation() - kInTheRoom.translation()).norm();
  };
  EXPECT_LT(error(), 0.015);
  candidate.seen_from_node = false;
  EXPECT_GT(error(), 0.03) << "nothing pulls";
}

}  // namespace
}  // namespace enfilade::slam
