// SPDX-License-Identifier: Apache-2.0
#include "core/closure/session_track.h"

#include <random>

#include "gmock/gmock.h"
#include "tests/support/pose_matchers.h"

namespace enfilade::closure {
namespace {

using ::enfilade::testing::PoseNear;

constexpr TimeNs kSecond = kNsPerSecond;

TEST(SessionTrack, CarriesTheNearestMappedPoseByOdometry) {
  // Odometry's frame is turned by 90 degrees against the map's.
  const SessionTrack track({{10 * kSecond, {5, 5, 0}}},
                           {{10 * kSecond, {0, 0, M_PI_2}}, {10 * kSecond + kSecond / 2, {0, 1, M_PI_2}}}, {});
  const auto pose = track.PoseAt(10 * kSecond + kSecond / 4);
  ASSERT_TRUE(pose.has_value());
  EXPECT_THAT(pose->pose, PoseNear(Pose2{5.5, 5, 0}, 1e-9, 1e-9));
  EXPECT_GT(pose->covariance(0, 0), 0.0);
  EXPECT_LT(pose->covariance(0, 0), 0.001);
}

TEST(SessionTrack, GivesWhatOdometrySeesInTheMap) {
  const SessionTrack track({{0, {1, 0, 0}}}, {{0, {10, 10, M_PI}}, {kSecond / 2, {9, 10, M_PI}}}, {});
  const auto door = track.ToMap({7, 10, M_PI_2}, kSecond / 2);
  ASSERT_TRUE(door.has_value());
  EXPECT_THAT(door->pose, PoseNear(Pose2{4, 0, -M_PI_2}, 1e-9, 1e-9));
}

// However far from the map's origin, and however unsure of where that is.
TEST(SessionTrack, ThePoseFromADoorIsAsAccurateAsMatching) {
  const SessionTrack track({{0, {100, 0, 0}}, {kSecond, {102, 0, 0}}}, {{0, {0, 0, 0}}, {kSecond, {2.3, 0.1, 0.05}}},
                           {});
  const auto way = track.RelativePose({0, 0, 0}, 0, kSecond);
  ASSERT_TRUE(way.has_value());
  EXPECT_THAT(way->pose, PoseNear(Pose2{2, 0, 0}, 1e-9, 1e-9));
  EXPECT_NEAR(way->covariance(0, 0), 2 * 0.02 * 0.02, 1e-9);
  EXPECT_NEAR(way->covariance(1, 1), 2 * 0.02 * 0.02 + 4 * 0.005 * 0.005, 1e-9);
  EXPECT_NEAR(way->covariance(2, 2), 2 * 0.005 * 0.005, 1e-9);
  EXPECT_FALSE(track.RelativePose({0, 0, 0}, 0, 60 * kSecond).has_value());
}

TEST(SessionTrack, WithoutOdometryTheNearestScanIsTheRobotsPose) {
  const SessionTrack track({{0, {1, 0, 0}}, {kSecond, {2, 0, 0}}}, {}, {});
  EXPECT_THAT(track.PoseAt(kSecond + kSecond / 5)->pose, PoseNear(Pose2{2, 0, 0}, 1e-9, 1e-9));
  EXPECT_THAT(track.ToMap({70, 1, 2}, kSecond)->pose, PoseNear(Pose2{2, 0, 0}, 1e-9, 1e-9));
  EXPECT_FALSE(track.PoseAt(3 * kSecond).has_value());
}

TEST(SessionTrack, HasNoPoseWhenNothingWasMapped) {
  const SessionTrack nothing({}, {{0, {}}, {kSecond, {}}}, {});
  EXPECT_FALSE(nothing.PoseAt(0).has_value());
  EXPECT_FALSE(nothing.ToMap({}, 0).has_value());
  const SessionTrack early({{0, {}}}, {{0, {}}, {60 * kSecond, {}}}, {});
  EXPECT_FALSE(early.PoseAt(60 * kSecond).has_value());
  EXPECT_FALSE(early.OdometryAt(30 * kSecond).has_value());
}

TEST(SessionTrack, GuessesAPoseAtAnyTime) {
  const slam::StampedPose start{5 * kSecond, {7, 7, 0}};
  const SessionTrack nothing({}, {}, {});
  const PoseWithCovariance lost = nothing.GuessPoseAt(9 * kSecond, start);
  EXPECT_THAT(lost.pose, PoseNear(Pose2{7, 7, 0}, 1e-9, 1e-9));
  EXPECT_GT(lost.covariance(0, 0), 1.0) << "4 s unseen";
  // A gap in the odometry: the way is known, when it was driven is not.
  const SessionTrack gap({{0, {1, 0, 0}}}, {{0, {0, 0, 0}}, {20 * kSecond, {3, 0, 0}}}, {});
  const PoseWithCovariance carried = gap.GuessPoseAt(20 * kSecond, start);
  EXPECT_THAT(carried.pose, PoseNear(Pose2{4, 0, 0}, 1e-9, 1e-9));
  EXPECT_LT(carried.covariance(0, 0), 0.01);
  EXPECT_GT(gap.GuessPoseAt(25 * kSecond, start).covariance(0, 0), 1.0) << "5 s without odometry";
  EXPECT_LE(gap.GuessPoseAt(4000 * kSecond, start).covariance(2, 2), 11.0) << "a full turn is all there is";
}

TEST(SessionTrack, TakesSamplesInAnyOrder) {
  const SessionTrack track({{kSecond, {1, 0, 0}}, {0, {0, 0, 0}}}, {{kSecond, {1, 0, 0}}, {0, {0, 0, 0}}}, {});
  EXPECT_THAT(track.PoseAt(kSecond / 2)->pose, PoseNear(Pose2{0.5, 0, 0}, 1e-9, 1e-9));
}

TEST(SessionTrack, BridgesGapsUpToItsLimits) {
  struct Case {
    const char* what;
    double mapped;                 // s
    std::vector<double> odometry;  // s
    double asked;                  // s
    bool has_pose;
  };
  const std::vector<Case> cases = {
      {"at the scan", 0, {0}, 0, true},
      {"odometry all the way", 0, {0, 0.5, 9.5, 9.9}, 9.9, true},
      {"mapped too long ago", 0, {0, 10.1}, 10.1, false},
      {"mapped later", 9.9, {0, 9.9}, 0, true},
      {"mapped much later", 10.1, {0, 10.1}, 0, false},
      {"no odometry at the scan", 0, {2}, 2, false},
      {"no odometry at the time", 0, {0}, 2, false},
      {"no odometry, but close", 0, {}, 0.9, true},
      {"no odometry, not close", 0, {}, 1.1, false},
      {"odometry near enough to both", 0, {-0.4, 1.6}, 1.2, true},
  };
  for (const Case& one : cases) {
    std::vector<sensor::Odometry> odometry;
    for (const double t : one.odometry) odometry.push_back({DurationOf(t), {t, 0, 0}});
    const SessionTrack track({{DurationOf(one.mapped), {1, 2, 0.3}}}, odometry, {});
    EXPECT_EQ(track.PoseAt(DurationOf(one.asked)).has_value(), one.has_pose) << one.what;
  }
}

TEST(SessionTrack, InterpolatesOdometryAlongTheShorterArc) {
  const SessionTrack track({{0, {}}}, {{0, {0, 0, 3.0}}, {kSecond, {2, 0, -3.0}}}, {});
  const auto middle = track.OdometryAt(kSecond / 2);
  ASSERT_TRUE(middle.has_value());
  EXPECT_THAT(*middle, PoseNear(Pose2{1, 0, M_PI}, 1e-9, 1e-9));
}

TEST(SessionTrack, OfTwoScansAtTheSameDistanceInTimeTheEarlierCounts) {
  const SessionTrack track({{0, {1, 0, 0}}, {kSecond, {5, 0, 0}}}, {{0, {}}, {kSecond, {}}}, {});
  EXPECT_THAT(track.PoseAt(kSecond / 2)->pose, PoseNear(Pose2{1, 0, 0}, 1e-9, 1e-9));
  EXPECT_THAT(track.PoseAt(kSecond / 2 + 1)->pose, PoseNear(Pose2{5, 0, 0}, 1e-9, 1e-9));
}

TEST(SessionTrack, TheCovarianceGrowsWithTheWayFromTheNearestScan) {
  std::vector<sensor::Odometry> odometry;
  for (int i = 0; i <= 10; ++i) odometry.push_back({i * kSecond / 2, {0.5 * i, 0, 0}});
  const SessionTrack track({{0, {0, 0, 0}}}, odometry, {});
  EXPECT_EQ(track.PoseAt(0)->covariance, Eigen::Matrix3d::Zero());
  double before = 0.0;
  for (int i = 1; i <= 10; ++i) {
    const double variance = track.PoseAt(i * kSecond / 2)->covariance(0, 0);
    EXPECT_GT(variance, before);
    EXPECT_NEAR(std::sqrt(variance), 0.02 * 0.5 * i, 1e-9) << "2 cm per metre";
    before = variance;
  }
}

// A robot that turns on the spot has moved, too, as far as odometry's errors go.
TEST(SessionTrack, TurningAddsToTheCovariance) {
  const SessionTrack track({{0, {}}}, {{0, {0, 0, 0}}, {kSecond, {0, 0, 1.0}}}, {});
  EXPECT_GT(track.PoseAt(kSecond)->covariance(2, 2), 0.0);
}

class RandomTrack {
 public:
  explicit RandomTrack(unsigned seed) : random_(seed) {
    Pose2 pose = RandomPose();
    for (int i = 0; i < 40; ++i) {
      pose = pose * Pose2{Uniform(0.0, 0.2), 0.0, Uniform(-0.3, 0.3)};
      odometry.push_back({i * kSecond / 5, pose});
      if (i % 7 == 0) trajectory.push_back({i * kSecond / 5, RandomPose()});
    }
  }
  Pose2 RandomPose() { return {Uniform(-50, 50), Uniform(-50, 50), Uniform(-3, 3)}; }
  TimeNs RandomTime() { return static_cast<TimeNs>(Uniform(0.0, 39.0) * static_cast<double>(kSecond) / 5); }

  std::vector<slam::StampedPose> trajectory;
  std::vector<sensor::Odometry> odometry;

 private:
  double Uniform(double from, double to) { return std::uniform_real_distribution<>(from, to)(random_); }
  std::mt19937 random_;
};

TEST(SessionTrack, TheOdometryFramesOriginDoesNotMatter) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    RandomTrack random(seed);
    const SessionTrack track(random.trajectory, random.odometry, {});
    const Pose2 T_other_odom = random.RandomPose();
    std::vector<sensor::Odometry> moved = random.odometry;
    for (sensor::Odometry& sample : moved) sample.T_odom_robot = T_other_odom * sample.T_odom_robot;
    const SessionTrack other(random.trajectory, moved, {});
    const TimeNs time = random.RandomTime();
    const Pose2 T_odom_x = random.RandomPose();
    EXPECT_THAT(other.PoseAt(time)->pose, PoseNear(track.PoseAt(time)->pose, 1e-6, 1e-9)) << seed;
    EXPECT_TRUE(other.PoseAt(time)->covariance.isApprox(track.PoseAt(time)->covariance, 1e-6)) << seed;
    EXPECT_THAT(other.ToMap(T_other_odom * T_odom_x, time)->pose,
                PoseNear(track.ToMap(T_odom_x, time)->pose, 1e-6, 1e-9))
        << seed;
  }
}

// However far away the map's origin is.
TEST(SessionTrack, TheMapsOriginDoesNotMatterToRelativePoses) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    RandomTrack random(seed);
    const SessionTrack track(random.trajectory, random.odometry, {});
    const Pose2 T_other_map = random.RandomPose();
    std::vector<slam::StampedPose> moved = random.trajectory;
    for (slam::StampedPose& sample : moved) sample.T_map_robot = T_other_map * sample.T_map_robot;
    const SessionTrack other(moved, random.odometry, {});
    const TimeNs seen = random.RandomTime();
    const TimeNs time = random.RandomTime();
    const Pose2 T_odom_x = *track.OdometryAt(seen) * Pose2{1.0, 0.2, 0.1};
    const auto a = track.RelativePose(T_odom_x, seen, time);
    const auto b = other.RelativePose(T_odom_x, seen, time);
    ASSERT_TRUE(a && b) << seed;
    EXPECT_THAT(b->pose, PoseNear(a->pose, 1e-6, 1e-9)) << seed;
    EXPECT_TRUE(b->covariance.isApprox(a->covariance, 1e-5)) << seed;
    EXPECT_THAT(a->pose, PoseNear(Between(track.ToMap(T_odom_x, seen)->pose, track.PoseAt(time)->pose), 1e-6, 1e-9));
  }
}

}  // namespace
}  // namespace enfilade::closure
