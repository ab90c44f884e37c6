// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/session_scene.h"

#include <gmock/gmock.h>

#include <functional>
#include <vector>

#include "tests/support/pose_matchers.h"
#include "tests/unit/server/closure/passed_door.h"

namespace enfilade::server {
namespace {

using ::enfilade::testing::PoseNear;
using sensor::Camera;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

ViewWindow Window(double time, double from, double to) {
  return {.time = PassedDoorLog::At(time), .from = PassedDoorLog::At(from), .to = PassedDoorLog::At(to)};
}

std::vector<std::int64_t> Sequences(const std::vector<SessionScene::SeenImage>& images) {
  std::vector<std::int64_t> sequences;
  for (const auto& image : images) sequences.push_back(image.sequence);
  return sequences;
}

TEST(SessionScene, PosesHaveTheKeyframesCovariance) {
  const SessionScene scene = PassedDoorLog().Scene();
  const auto pose = scene.PoseAt(PassedDoorLog::At(13.0));
  ASSERT_TRUE(pose.has_value());
  EXPECT_THAT(pose->pose, PoseNear(Pose2{6.5, 0, 0}, 1e-9, 1e-9));
  EXPECT_NEAR(pose->covariance(1, 1), 0.09, 1e-9);
  const auto door = scene.DoorPose();
  ASSERT_TRUE(door.has_value());
  EXPECT_THAT(door->pose, PoseNear(Pose2{5, 0, 0}, 1e-9, 1e-9)) << "from the odometry frame into the map";
  EXPECT_NEAR(door->covariance(0, 0), 0.04, 1e-9);
}

// The keyframe's covariance is that of the map's frame, which both poses share.
TEST(SessionScene, TheRobotsPoseFromTheDoorDoesNotHaveTheKeyframesCovariance) {
  const auto from_door = PassedDoorLog().Scene().RobotFromDoor();
  ASSERT_TRUE(from_door.has_value());
  EXPECT_THAT(from_door->pose, PoseNear(Pose2{1.5, 0, 0}, 1e-9, 1e-9));
  EXPECT_LT(from_door->covariance(0, 0), 0.01);
}

TEST(SessionScene, HasNoPosesIfNothingWasMapped) {
  PassedDoorLog log;
  log.ForgetTrajectory();
  log.AddScan(12.0);
  const SessionScene scene = log.Scene();
  EXPECT_FALSE(scene.DoorPose().has_value());
  EXPECT_FALSE(scene.PoseAt(log.report().time).has_value());
  EXPECT_FALSE(scene.RobotFromDoor().has_value());
  EXPECT_THAT(scene.ScansBetween(log.report().door_time, log.report().time), IsEmpty());
  EXPECT_TRUE(scene.OdometryAt(log.report().time).has_value()) << "odometry needs no map";
}

TEST(SessionScene, FindsImagesOfOneCameraTheNearestFirst) {
  PassedDoorLog log;
  const std::int64_t early = log.AddImage(10.5, Camera::kFront);
  const std::int64_t late = log.AddImage(13.1, Camera::kFront);
  const std::int64_t middle = log.AddImage(12.0, Camera::kFront);
  const std::int64_t rear = log.AddImage(13.0, Camera::kRear);
  log.AddImage(13.0, Camera::kFront, sensor::ImageEncoding::kDepthPng16);
  log.AddImage(9.9, Camera::kFront);
  log.AddImage(13.6, Camera::kFront);
  const SessionScene scene = log.Scene();
  const ViewWindow window = Window(13.0, 10.0, 13.5);
  EXPECT_THAT(Sequences(scene.FindImages(Camera::kFront, window, 10)), ElementsAre(late, middle, early));
  EXPECT_THAT(Sequences(scene.FindImages(Camera::kFront, window, 2)), ElementsAre(late, middle));
  EXPECT_THAT(Sequences(scene.FindImages(Camera::kFront, window, 0)), IsEmpty());
  EXPECT_THAT(Sequences(scene.FindImages(Camera::kRear, window, 10)), ElementsAre(rear));
}

TEST(SessionScene, WindowsIncludeTheirEnds) {
  PassedDoorLog log;
  const std::int64_t first = log.AddImage(10.0, Camera::kFront);
  const std::int64_t last = log.AddImage(13.5, Camera::kFront);
  EXPECT_THAT(Sequences(log.Scene().FindImages(Camera::kFront, Window(13.0, 10.0, 13.5), 10)),
              ElementsAre(last, first));
  log.AddCloud(10.0);
  EXPECT_TRUE(log.Scene().FindCloud(Window(12.0, 10.0, 11.0)).has_value());
  EXPECT_FALSE(log.Scene().FindCloud(Window(12.0, 10.1, 11.0)).has_value());
}

TEST(SessionScene, ImagesOfTheSameDistanceInTimeComeInTheLogsOrder) {
  PassedDoorLog log;
  const std::int64_t before = log.AddImage(11.5, Camera::kFront);
  const std::int64_t after = log.AddImage(12.5, Camera::kFront);
  EXPECT_THAT(Sequences(log.Scene().FindImages(Camera::kFront, Window(12.0, 10.0, 14.0), 10)),
              ElementsAre(before, after));
}

TEST(SessionScene, FindsTheNearestCloud) {
  PassedDoorLog log;
  EXPECT_FALSE(log.Scene().FindCloud(Window(12.0, 0.0, 20.0)).has_value());
  log.AddCloud(10.5);
  const std::int64_t near = log.AddCloud(12.4);
  log.AddCloud(14.0);
  EXPECT_EQ(log.Scene().FindCloud(Window(12.0, 10.0, 20.0))->sequence, near);
}

TEST(SessionScene, HasViewsIfAnImageOrACloudIsInTheWindow) {
  const ViewWindow window = Window(10.0, 7.0, 13.0);
  struct Case {
    const char* what;
    std::function<void(PassedDoorLog&)> add;
    bool has_views;
  };
  const std::vector<Case> cases = {
      {"nothing", [](PassedDoorLog&) {}, false},
      {"front", [](PassedDoorLog& log) { log.AddImage(9.0, Camera::kFront); }, true},
      {"rear", [](PassedDoorLog& log) { log.AddImage(9.0, Camera::kRear); }, true},
      {"depth only", [](PassedDoorLog& log) { log.AddImage(9.0, Camera::kFront, sensor::ImageEncoding::kDepthPng16); },
       false},
      {"cloud", [](PassedDoorLog& log) { log.AddCloud(9.0); }, true},
      {"too early", [](PassedDoorLog& log) { log.AddCloud(6.9); }, false},
      {"too late", [](PassedDoorLog& log) { log.AddImage(13.1, Camera::kFront); }, false},
      {"scans", [](PassedDoorLog& log) { log.AddScan(10.0); }, false},
  };
  for (const Case& one : cases) {
    PassedDoorLog log;
    one.add(log);
    EXPECT_EQ(log.Scene().HasViews(window), one.has_views) << one.what;
  }
}

TEST(SessionScene, ScansComeFromTheLaterHalfOfThePathAndStandApart) {
  PassedDoorLog log;
  for (int i = 0; i <= 35; ++i) log.AddScan(8.0 + 0.2 * i);  // every 10 cm
  const auto placed = log.Scene().ScansBetween(log.report().door_time, log.report().time);
  ASSERT_THAT(placed, SizeIs(3)) << "of the last 0.75 m, every third";
  EXPECT_NEAR(placed.front().T_map_robot.pose.x, 6.5, 0.06) << "the latest first";
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const double x = placed[i].T_map_robot.pose.x;
    EXPECT_GE(x, 5.75 - 1e-6);
    EXPECT_LE(x, 6.5 + 1e-6);
    if (i > 0) {
      EXPECT_GE(placed[i - 1].T_map_robot.pose.x - x, 0.25 - 1e-6);
    }
    EXPECT_GT(placed[i].T_map_robot.covariance(1, 1), 0.08) << "with the keyframe's covariance";
  }
}

TEST(SessionScene, ScansFromBeforeTheDoorAreNotKept) {
  PassedDoorLog log;
  log.AddScan(9.0);
  EXPECT_THAT(log.Scene().ScansBetween(PassedDoorLog::At(8.0), PassedDoorLog::At(9.5)), IsEmpty());
}

}  // namespace
}  // namespace enfilade::server
