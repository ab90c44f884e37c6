// SPDX-License-Identifier: Apache-2.0
#include "core/localization/localize.h"

#include <cmath>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/localization/drawn_map.h"

namespace enfilade::localization {
namespace {

using ::testing::HasSubstr;
using testing::PoseNear;

Localization Locate(const std::vector<QueryScan>& scans, const std::vector<CandidateMap>& maps) {
  absl::StatusOr<Localization> found = Localize(scans, maps, LocalizationOptions(), GoOn);
  EXPECT_OK(found);
  return found.ok() ? *std::move(found) : Localization();
}

// Scans along the way, with odometry that turns too far by `drift` (rad) in all.
std::vector<QueryScan> Drive(const DrawnMap& map, const std::vector<Pose2>& way, double drift = 0.0) {
  std::vector<QueryScan> scans;
  Pose2 T_odom_robot{3.0, -2.0, 0.7};
  for (std::size_t i = 0; i < way.size(); ++i) {
    if (i > 0) {
      Pose2 motion = Between(way[i - 1], way[i]);
      motion.yaw += drift / static_cast<double>(way.size() - 1);
      T_odom_robot = T_odom_robot * motion;
    }
    scans.push_back({map.Scan(way[i]), T_odom_robot});
  }
  return scans;
}

TEST(LocalizeTest, OneScanSufficesWhereNothingIsTwice) {
  const DrawnMap room = UniqueRoom();
  for (const Pose2& truth : {Pose2{1.5, 2.5, 0.3}, Pose2{3.9, 1.1, -2.0}, Pose2{7.3, 2.1, 3.0}, Pose2{6.0, 4.0, 1.6}}) {
    const Localization found = Locate({{room.Scan(truth), std::nullopt}}, {room.Candidate()});
    ASSERT_FALSE(found.poses.empty()) << found.reason;
    EXPECT_THAT(found.poses.front().T_map_robot.pose, PoseNear(truth, 0.05, 0.02));
    EXPECT_TRUE(found.poses.front().confident) << found.reason;
    EXPECT_GT(found.poses.front().score, 0.95);
    EXPECT_EQ(found.poses.front().odds_behind, 0.0);
    EXPECT_LT(std::sqrt(found.poses.front().T_map_robot.covariance(0, 0)), 0.15);
    EXPECT_LT(std::sqrt(found.poses.front().T_map_robot.covariance(2, 2)), 0.05);
  }
}

TEST(LocalizeTest, AScannerThatLooksAheadSuffices) {
  const DrawnMap room = UniqueRoom();
  const Pose2 truth{7.6, 3.2, -2.9};
  const Localization found = Locate({{room.Scan(truth, M_PI), std::nullopt}}, {room.Candidate()});
  ASSERT_FALSE(found.poses.empty()) << found.reason;
  EXPECT_THAT(found.poses.front().T_map_robot.pose, PoseNear(truth, 0.05, 0.02));
}

TEST(LocalizeTest, BothPosesOfASymmetricRoomAreListedAndNoneIsCertain) {
  const DrawnMap room = SymmetricRoom();
  const Pose2 truth{2.0, 1.2, 0.5};
  const Pose2 turned{6.0 - truth.x, 3.5 - truth.y, truth.yaw - M_PI};
  const Localization found = Locate({{room.Scan(truth), std::nullopt}}, {room.Candidate()});
  ASSERT_GE(found.poses.size(), 2U);
  EXPECT_FALSE(found.poses.front().confident);
  EXPECT_THAT(found.reason, HasSubstr("another place"));
  const std::vector<Pose2> best = {found.poses[0].T_map_robot.pose, found.poses[1].T_map_robot.pose};
  EXPECT_THAT(best, ::testing::UnorderedElementsAre(PoseNear(truth, 0.05, 0.02), PoseNear(turned, 0.05, 0.02)));
  EXPECT_LT(found.poses[1].odds_behind, 8.0);
}

TEST(LocalizeTest, DrivingDecidesBetweenRoomsThatAreAlike) {
  const DrawnMap rooms = TwoRoomsAlike();
  // From deep in the right room, out of its door and along the corridor.
  const std::vector<Pose2> way = {{8.0, 2.9, -1.9},   {7.8, 2.5, -1.8},  {7.7, 2.1, -1.7},  {7.6, 1.8, -1.6},
                                  {7.55, 1.5, -1.57}, {7.5, 1.2, -1.57}, {7.5, 0.95, -1.8}, {7.4, 0.8, -2.6},
                                  {7.1, 0.75, -3.1},  {6.8, 0.75, 3.1}};
  const Localization one = Locate({{rooms.Scan(way.front()), std::nullopt}}, {rooms.Candidate()});
  ASSERT_GE(one.poses.size(), 2U) << one.reason;
  EXPECT_FALSE(one.poses.front().confident) << one.reason;
  for (const double drift : {0.0, 0.1, -0.1}) {
    const Localization driven = Locate(Drive(rooms, way, drift), {rooms.Candidate()});
    ASSERT_FALSE(driven.poses.empty()) << driven.reason;
    EXPECT_THAT(driven.poses.front().T_map_robot.pose, PoseNear(way.back(), 0.05, 0.02));
    EXPECT_TRUE(driven.poses.front().confident) << driven.reason;
  }
}

TEST(LocalizeTest, ARoomInAnotherMapIsARivalUnlessItIsTheSamePlace) {
  const DrawnMap room = UniqueRoom();
  const std::vector<QueryScan> scan = {{room.Scan({7.3, 2.1, 3.0}), std::nullopt}};
  CandidateMap first = room.Candidate();
  CandidateMap second = room.Candidate();
  const Localization rivals = Locate(scan, {first, second});
  ASSERT_EQ(rivals.poses.size(), 2U);
  EXPECT_FALSE(rivals.poses.front().confident);
  EXPECT_THAT(rivals.reason, HasSubstr("another map"));
  first.T_world_map = Pose2{5.0, 1.0, 0.2};
  second.T_world_map = Pose2{5.1, 1.0, 0.2};
  EXPECT_TRUE(Locate(scan, {first, second}).poses.front().confident);
  second.T_world_map = Pose2{15.0, 1.0, 0.2};
  EXPECT_FALSE(Locate(scan, {first, second}).poses.front().confident);
}

TEST(LocalizeTest, TheRightOneOfSeveralMapsIsFound) {
  const DrawnMap room = UniqueRoom();
  const Localization found = Locate({{room.Scan({3.0, 3.5, 1.0}), std::nullopt}},
                                    {TwoRoomsAlike().Candidate(), room.Candidate(), SymmetricRoom().Candidate()});
  ASSERT_FALSE(found.poses.empty());
  EXPECT_EQ(found.poses.front().map, 1U);
  EXPECT_TRUE(found.poses.front().confident) << found.reason;
}

TEST(LocalizeTest, AnUnknownRoomIsNowhereOrAtLeastNotCertain) {
  const std::vector<CandidateMap> maps = {SymmetricRoom().Candidate(), TwoRoomsAlike().Candidate()};
  for (const Pose2& truth : {Pose2{1.5, 2.5, 0.3}, Pose2{3.9, 1.1, -2.0}, Pose2{7.3, 2.1, 3.0}, Pose2{6.0, 4.0, 1.6}}) {
    const Localization found = Locate({{UniqueRoom().Scan(truth), std::nullopt}}, maps);
    EXPECT_TRUE(found.poses.empty() || !found.poses.front().confident) << found.reason;
    EXPECT_NE(found.reason, "");
  }
  EXPECT_TRUE(Locate({{UniqueRoom().Scan({1.5, 2.5, 0.3}), std::nullopt}}, {}).poses.empty());
}

// The left room is drawn as unknown. A robot that comes out of it has seen what is in the right one, then the corridor.
TEST(LocalizeTest, ARoomThatNobodyHasSeenIsNotTakenForAnotherForCertain) {
  const DrawnMap whole = TwoRoomsAlike();
  std::vector<std::string> rows;
  for (int row = 17; row >= 0; --row) {
    std::string drawn;
    for (int column = 0; column < 41; ++column) {
      const char at = whole.At((column + 0.5) * DrawnMap::kCharacter, (row + 0.5) * DrawnMap::kCharacter);
      drawn += column < 20 && row > 6 ? '?' : at;
    }
    rows.push_back(drawn);
  }
  const std::vector<Pose2> way = {{2.6, 2.9, -1.9},  {2.5, 2.5, -1.7},  {2.35, 2.1, -1.7}, {2.25, 1.8, -1.6},
                                  {2.2, 1.4, -1.57}, {2.2, 1.0, -1.57}, {2.2, 0.7, -1.57}};
  for (std::size_t count = 6; count <= way.size(); ++count) {
    const std::vector<Pose2> driven(way.begin(), way.begin() + static_cast<std::ptrdiff_t>(count));
    const Localization found = Locate(Drive(whole, driven), {DrawnMap(rows).Candidate()});
    if (found.poses.empty() || !found.poses.front().confident) continue;
    EXPECT_THAT(found.poses.front().T_map_robot.pose, PoseNear(driven.back(), 0.1, 0.05))
        << count << " scans: " << found.reason;
  }
}

TEST(LocalizeTest, AlongACorridorThePositionIsNotCertain) {
  const std::string wall(160, '#');
  const std::string middle = "#" + std::string(158, ' ') + "#";
  const DrawnMap corridor({wall, middle, middle, middle, middle, middle, middle, wall});
  const Localization found =
      Locate({{corridor.Scan({20.0, 1.0, 0.0}, 2.0 * M_PI, 6.0F), std::nullopt}}, {corridor.Candidate()});
  ASSERT_FALSE(found.poses.empty());
  EXPECT_FALSE(found.poses.front().confident);
}

TEST(LocalizeTest, APriorBoundsTheSearch) {
  const DrawnMap room = SymmetricRoom();
  const Pose2 truth{2.0, 1.2, 0.5};
  CandidateMap map = room.Candidate();
  PoseWithCovariance prior{{2.4, 1.0, 0.3}, Eigen::Vector3d(0.04, 0.04, 0.01).asDiagonal()};
  map.T_map_robot = prior;
  const Localization near = Locate({{room.Scan(truth), std::nullopt}}, {map});
  ASSERT_FALSE(near.poses.empty()) << near.reason;
  EXPECT_THAT(near.poses.front().T_map_robot.pose, PoseNear(truth, 0.05, 0.02));
  EXPECT_TRUE(near.poses.front().confident) << near.reason;
  map.T_map_robot->pose.yaw = 2.0;
  EXPECT_TRUE(Locate({{room.Scan(truth), std::nullopt}}, {map}).poses.empty());
  map.T_map_robot->pose = {200.0, 100.0, 0.5};
  EXPECT_TRUE(Locate({{room.Scan(truth), std::nullopt}}, {map}).poses.empty());
}

TEST(LocalizeTest, PeopleInTheWayDoNotMislead) {
  const DrawnMap room = UniqueRoom();
  const Pose2 truth{6.5, 2.6, 0.4};
  sensor::LaserScan scan = room.Scan(truth);
  for (std::size_t i = 100; i < 130; ++i) scan.ranges[i] = std::min(scan.ranges[i], 0.9F);
  const Localization found = Locate({{scan, std::nullopt}}, {room.Candidate()});
  ASSERT_FALSE(found.poses.empty());
  EXPECT_THAT(found.poses.front().T_map_robot.pose, PoseNear(truth, 0.05, 0.02));
}

TEST(LocalizeTest, SaysWhatIsWrongWithTheScans) {
  const DrawnMap room = UniqueRoom();
  const std::vector<CandidateMap> maps = {room.Candidate()};
  const auto error = [&](const std::vector<QueryScan>& scans) {
    return Localize(scans, maps, LocalizationOptions(), GoOn).status();
  };
  const QueryScan good{room.Scan({1.5, 2.5, 0.3}), Pose2()};
  EXPECT_STATUS(error({}), absl::StatusCode::kInvalidArgument, HasSubstr("no scans"));
  QueryScan bad = good;
  bad.T_odom_robot.reset();
  EXPECT_STATUS(error({good, bad}), absl::StatusCode::kInvalidArgument, HasSubstr("scans[1] has no odometry"));
  bad = good;
  bad.T_odom_robot->x = std::nan("");
  EXPECT_STATUS(error({good, bad}), absl::StatusCode::kInvalidArgument, HasSubstr("scans[1]"));
  bad = good;
  bad.scan.angle_increment = 0.0;
  EXPECT_STATUS(error({bad}), absl::StatusCode::kInvalidArgument, HasSubstr("scans[0]"));
  bad = good;
  for (float& range : bad.scan.ranges) range = std::numeric_limits<float>::quiet_NaN();
  EXPECT_STATUS(error({bad}), absl::StatusCode::kInvalidArgument, HasSubstr("hits"));
  EXPECT_OK(error({bad, good})) << "one scan that sees walls suffices";
}

TEST(LocalizeTest, EndsWhenTheCallerSaysSoOrAMapCannotBeLoaded) {
  const DrawnMap room = UniqueRoom();
  const std::vector<QueryScan> scans = {{room.Scan({1.5, 2.5, 0.3}), std::nullopt}};
  EXPECT_CODE(Localize(scans, {room.Candidate()}, LocalizationOptions(), [] { return absl::CancelledError("gone"); }),
              absl::StatusCode::kCancelled);
  EXPECT_CODE(Localize(scans, {{[] { return absl::DataLossError("damaged"); }}}, LocalizationOptions(), GoOn),
              absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace enfilade::localization
