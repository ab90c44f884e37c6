// SPDX-License-Identifier: Apache-2.0
#include "perception/cloud/registration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <fstream>
#include <limits>
#include <sstream>

#include "perception/cloud/decode_cloud.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"
#include "tests/unit/perception/cloud/rooms.h"

namespace enfilade::perception {
namespace {

using enfilade::testing::PoseNear;
using ::testing::HasSubstr;
using testing::PoseOf;
using testing::Room;

constexpr double kDegree = std::numbers::pi / 180.0;

struct Error {
  double metres = 0.0;
  double radians = 0.0;
};

Error ErrorOf(const Eigen::Isometry3d& T, const Eigen::Isometry3d& truth) {
  const Eigen::Isometry3d error = truth.inverse() * T;
  return {error.translation().norm(), std::abs(Eigen::AngleAxisd(error.linear()).angle())};
}

// The room as seen by a robot at T_room_robot.
Cloud SeenFrom(const Eigen::Isometry3d& T_room_robot, std::uint32_t room, std::uint32_t seed) {
  return Transformed(Room(room, seed), T_room_robot.inverse());
}

Registration Register(const Cloud& source, const Cloud& target, const Eigen::Isometry3d& guess,
                      const RegistrationOptions& options = {}) {
  return RegisterClouds(source, target, guess, options).value();
}

TEST(RegistrationTest, FindsThePoseFromAWrongGuess) {
  const Eigen::Isometry3d truth = PoseOf(0.6, -0.4, 0.3);
  for (const RegistrationMethod method : {RegistrationMethod::kGicp, RegistrationMethod::kIcp}) {
    RegistrationOptions options;
    options.method = method;
    for (std::uint32_t room = 1; room <= 3; ++room) {
      const Registration found = Register(SeenFrom(truth, room, 7), Room(room, 8), PoseOf(0.0, 0.0, 0.0), options);
      EXPECT_TRUE(found.accepted) << found.reason;
      EXPECT_FALSE(found.turned);
      const Error error = ErrorOf(found.T_target_source, truth);
      EXPECT_LT(error.metres, 0.03);
      EXPECT_LT(error.radians, 0.4 * kDegree);
    }
  }
}

TEST(RegistrationTest, FindsATurnedRobot) {
  const Eigen::Isometry3d truth = PoseOf(0.5, 0.3, 3.0);
  const Registration found = Register(SeenFrom(truth, 4, 7), Room(4, 8), PoseOf(0.0, 0.0, 0.0));
  EXPECT_TRUE(found.accepted) << found.reason;
  EXPECT_TRUE(found.turned);
  EXPECT_LT(ErrorOf(found.T_target_source, truth).metres, 0.03);
  // A rectangular room turned by 180 degrees fits too, but worse.
  RegistrationOptions options;
  options.try_turned = false;
  EXPECT_LT(Register(SeenFrom(truth, 4, 7), Room(4, 8), PoseOf(0.0, 0.0, 0.0), options).inlier_share,
            found.inlier_share - 0.1);
}

TEST(RegistrationTest, RejectsAnotherRoom) {
  for (std::uint32_t room = 1; room <= 12; ++room) {
    const Registration found = Register(Room(room, 7), Room(room + 20, 8), PoseOf(0.0, 0.0, 0.0));
    EXPECT_FALSE(found.accepted) << room << ": " << found.reason;
  }
}

// The same clouds with the places swapped give the inverse.
TEST(RegistrationTest, IsPoseOfSourceInTarget) {
  const Eigen::Isometry3d truth = PoseOf(0.4, 0.7, -0.2);
  const Cloud source = SeenFrom(truth, 5, 7);
  const Cloud target = Room(5, 8);
  const Registration there = Register(source, target, Eigen::Isometry3d::Identity());
  const Registration back = Register(target, source, Eigen::Isometry3d::Identity());
  EXPECT_LT(ErrorOf(there.T_target_source, truth).metres, 0.03);
  EXPECT_LT(ErrorOf(back.T_target_source, truth.inverse()).metres, 0.03);
}

// Without an inverse: T_map_robot = T_map_target * T_target_source.
TEST(RegistrationTest, GivesTheRobotsPoseInTheExistingMap) {
  const Eigen::Isometry3d T_map_candidate = PoseOf(1.2, -0.8, 0.5);
  const Eigen::Isometry3d T_map_robot = PoseOf(0.4, -0.3, 0.5 + 170.0 * kDegree);
  const Cloud candidate = SeenFrom(T_map_candidate, 6, 7);
  const Cloud now = SeenFrom(T_map_robot, 6, 8);
  const Registration found = Register(now, candidate, Eigen::Isometry3d::Identity());
  ASSERT_TRUE(found.accepted) << found.reason;
  PoseWithCovariance T_map_target{{1.2, -0.8, 0.5}, Eigen::Vector3d(0.003, 0.003, 0.003).asDiagonal()};
  const PoseWithCovariance robot = RobotInMap(T_map_target, found);
  EXPECT_THAT(robot.pose, PoseNear(Pose2{0.4, -0.3, 0.5 + 170.0 * kDegree}, 0.03, 0.3 * kDegree));
  EXPECT_GT(robot.covariance(0, 0), 0.003);
}

// Normalised squared errors of x, y, yaw over many noises average 3 where the covariance is right.
TEST(RegistrationTest, StatesItsErrorWithinAFewTimes) {
  const Eigen::Isometry3d truth = PoseOf(0.1, 0.1, 0.05);
  double sum = 0.0;
  constexpr int kRuns = 12;
  for (std::uint32_t seed = 0; seed < kRuns; ++seed) {
    RegistrationOptions options;
    options.yaw_offsets = {0.0};
    options.try_turned = false;
    const Cloud source = Transformed(Room(7, 100 + seed, 0.02), truth.inverse());
    const PoseWithCovariance found = PlanarPose(Register(source, Room(7, 300 + seed, 0.02), truth, options));
    const Eigen::Vector3d error(found.pose.x - 0.1, found.pose.y - 0.1, WrapAngle(found.pose.yaw - 0.05));
    sum += error.dot(found.covariance.inverse() * error);
  }
  EXPECT_LT(sum / kRuns, 3.0 * 4.0);
  EXPECT_GT(sum / kRuns, 3.0 / 20.0);
}

// Two walls and a floor leave the way along them open.
TEST(RegistrationTest, ABareCorridorLeavesOneDirectionUnconstrained) {
  const auto corridor = [](std::uint32_t seed) {
    std::mt19937 rng(seed);
    std::uniform_real_distribution<float> unit(0.0F, 1.0F);
    std::normal_distribution<float> noise(0.0F, 0.01F);
    Cloud cloud;
    for (int i = 0; i < 20000; ++i) {
      const float x = 30.0F * (unit(rng) - 0.5F);
      const float z = 2.0F * unit(rng);
      cloud.points.emplace_back(x, (i % 2 == 0 ? 1.0F : -1.0F) + noise(rng), z);
      if (i % 2 == 0) cloud.points.emplace_back(x, 2.0F * unit(rng) - 1.0F, noise(rng));
    }
    return cloud;
  };
  const PoseWithCovariance found = PlanarPose(Register(corridor(1), corridor(2), Eigen::Isometry3d::Identity()));
  EXPECT_GT(found.covariance(0, 0), 50.0 * found.covariance(1, 1));
}

TEST(RegistrationTest, RejectsCloudsOfTooFewPoints) {
  const Cloud room = Room(1, 1);
  const Cloud one{{{1.0F, 2.0F, 3.0F}}};
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Cloud nothing{std::vector<Eigen::Vector3f>(1000, Eigen::Vector3f(nan, 0.0F, 0.0F))};
  for (const Cloud* poor : {&one, &nothing}) {
    const Registration as_source = Register(*poor, room, Eigen::Isometry3d::Identity());
    EXPECT_FALSE(as_source.accepted);
    EXPECT_THAT(as_source.reason, HasSubstr("the source has"));
    EXPECT_THAT(Register(room, *poor, Eigen::Isometry3d::Identity()).reason, HasSubstr("the target has"));
  }
  EXPECT_FALSE(Register({}, {}, Eigen::Isometry3d::Identity()).accepted);
}

TEST(RegistrationTest, LeavesOutPointsThatAreNotFinite) {
  const Eigen::Isometry3d truth = PoseOf(0.3, 0.2, 0.1);
  Cloud source = SeenFrom(truth, 8, 7);
  Cloud target = Room(8, 8);
  for (std::size_t i = 0; i < 5000; ++i) {
    source.points.insert(source.points.begin(), Eigen::Vector3f::Constant(std::numeric_limits<float>::infinity()));
    target.points.emplace_back(std::numeric_limits<float>::quiet_NaN(), 0.0F, 0.0F);
  }
  const Registration found = Register(source, target, Eigen::Isometry3d::Identity());
  EXPECT_TRUE(found.accepted) << found.reason;
  EXPECT_LT(ErrorOf(found.T_target_source, truth).metres, 0.03);
}

TEST(RegistrationTest, TakesAMillionPoints) {
  const Eigen::Isometry3d truth = PoseOf(0.2, -0.2, 0.1);
  const Cloud source = Transformed(Room(9, 7, 0.01, 1'000'000), truth.inverse());
  const Registration found = Register(source, Room(9, 8, 0.01, 1'000'000), Eigen::Isometry3d::Identity());
  EXPECT_TRUE(found.accepted) << found.reason;
  EXPECT_LT(ErrorOf(found.T_target_source, truth).metres, 0.02);
}

TEST(RegistrationTest, IsDeterministic) {
  const Cloud source = SeenFrom(PoseOf(0.3, 0.2, 0.1), 10, 7);
  const Cloud target = Room(10, 8);
  const Registration first = Register(source, target, Eigen::Isometry3d::Identity());
  const Registration second = Register(source, target, Eigen::Isometry3d::Identity());
  EXPECT_EQ(first.T_target_source.matrix(), second.T_target_source.matrix());
  EXPECT_EQ(first.covariance, second.covariance);
}

TEST(RegistrationTest, RefusesInvalidArguments) {
  const Cloud room = Room(1, 1);
  Eigen::Isometry3d nowhere = Eigen::Isometry3d::Identity();
  nowhere.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_STATUS(RegisterClouds(room, room, nowhere), absl::StatusCode::kInvalidArgument, HasSubstr("guess"));
  RegistrationOptions options;
  options.voxel = 0.0;
  EXPECT_STATUS(RegisterClouds(room, room, Eigen::Isometry3d::Identity(), options), absl::StatusCode::kInvalidArgument,
                HasSubstr("voxel"));
  const Cloud far{{{1e30F, 0.0F, 0.0F}}};
  EXPECT_STATUS(RegisterClouds(far, room, Eigen::Isometry3d::Identity()), absl::StatusCode::kInvalidArgument,
                HasSubstr("too far away"));
}

std::string ReadAll(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream bytes;
  bytes << file.rdbuf();
  return std::move(bytes).str();
}

TEST(RegistrationTest, FindsTheTransformOfALidarPair) {
  ENFILADE_RECORDING_OR_SKIP(folder, "clouds/small_gicp");
  ASSERT_OK_AND_ASSIGN(const Cloud source, DecodeCloud(ReadAll(folder / "source.ply")));
  ASSERT_OK_AND_ASSIGN(const Cloud target, DecodeCloud(ReadAll(folder / "target.ply")));
  EXPECT_EQ(source.points.size(), 69792U);
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  std::ifstream matrix(folder / "T_target_source.txt");
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) matrix >> truth.matrix()(row, column);
  }
  for (const double yaw : {0.0, std::numbers::pi}) {
    const Registration found = Register(source, target, PoseOf(0.0, 0.0, yaw));
    EXPECT_TRUE(found.accepted) << found.reason;
    EXPECT_LT(ErrorOf(found.T_target_source, truth).metres, 0.05);
    EXPECT_LT(ErrorOf(found.T_target_source, truth).radians, 0.5 * kDegree);
  }
}

TEST(RegistrationTest, JoinsTwoScansOfARoomFromThePublishedGuess) {
  ENFILADE_RECORDING_OR_SKIP(folder, "clouds/pcl");
  ASSERT_OK_AND_ASSIGN(const Cloud first, DecodeCloud(ReadAll(folder / "room_scan1.pcd")));
  ASSERT_OK_AND_ASSIGN(const Cloud second, DecodeCloud(ReadAll(folder / "room_scan2.pcd")));
  EXPECT_EQ(first.points.size(), 112586U);
  const Eigen::Isometry3d guess = PoseOf(1.79387, 0.720047, 0.6931);
  const Registration found = Register(second, first, guess);
  EXPECT_TRUE(found.accepted) << found.reason;
  const Registration turned = Register(second, first, guess * PoseOf(0.0, 0.0, std::numbers::pi));
  EXPECT_TRUE(turned.turned);
  EXPECT_LT(ErrorOf(turned.T_target_source, found.T_target_source).metres, 0.01);
  const Registration back = Register(first, second, guess.inverse());
  EXPECT_LT(ErrorOf(back.T_target_source, found.T_target_source.inverse()).metres, 0.05);
  ENFILADE_RECORDING_OR_SKIP(other, "clouds/small_gicp/target.ply");
  ASSERT_OK_AND_ASSIGN(const Cloud outside, DecodeCloud(ReadAll(other)));
  EXPECT_FALSE(Register(second, outside, guess).accepted);
}

}  // namespace
}  // namespace enfilade::perception
