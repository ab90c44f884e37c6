// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/evidence_keeper.h"

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "server/app/closure/apply_door_action.h"
#include "tests/support/pose_matchers.h"
#include "tests/unit/server/closure/passed_door.h"

namespace enfilade::server {
namespace {

using ::enfilade::testing::PoseNear;
using sensor::Camera;
using storage::EvidenceKind;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

const LinkPointId kPoint("point");

storage::DoorChange KeepBefore(const PassedDoorLog& log) {
  const closure::DoorKnowledge knowledge = log.Knowledge();
  const SessionScene scene = log.Scene();
  storage::DoorChange change;
  EvidenceKeeper(knowledge, scene, change).KeepBeforeDoor(kPoint);
  return change;
}

storage::DoorChange KeepBehind(const PassedDoorLog& log, const graph::Anchor& there) {
  const closure::DoorKnowledge knowledge = log.Knowledge();
  const SessionScene scene = log.Scene();
  storage::DoorChange change;
  EvidenceKeeper(knowledge, scene, change).KeepBehindDoor(kPoint, there);
  return change;
}

storage::DoorChange KeepSighting(const PassedDoorLog& log) {
  const closure::DoorKnowledge knowledge = log.Knowledge();
  const SessionScene scene = log.Scene();
  storage::DoorChange change;
  EvidenceKeeper(knowledge, scene, change).KeepSighting(kPoint);
  return change;
}

TEST(EvidenceKeeper, KeepsEveryKindForTheAnchorInTheSessionsMap) {
  PassedDoorLog log;
  const std::int64_t front = log.AddImage(6.6, Camera::kFront, sensor::ImageEncoding::kPng);
  const std::int64_t rear = log.AddImage(6.7, Camera::kRear);
  const std::int64_t cloud = log.AddCloud(6.8);
  const storage::DoorChange change = KeepBefore(log);
  ASSERT_THAT(change.evidence, SizeIs(3));
  EXPECT_THAT(change.verdict.evidence, ElementsAre(front, rear, cloud)) << "the verdict names the records";
  EXPECT_EQ(change.evidence[0].kind, EvidenceKind::kFrontImage);
  EXPECT_EQ(change.evidence[0].encoding, static_cast<std::int16_t>(sensor::ImageEncoding::kPng));
  EXPECT_EQ(change.evidence[1].kind, EvidenceKind::kRearImage);
  EXPECT_EQ(change.evidence[1].encoding, static_cast<std::int16_t>(sensor::ImageEncoding::kJpeg));
  EXPECT_EQ(change.evidence[2].kind, EvidenceKind::kCloud);
  EXPECT_EQ(change.evidence[2].encoding, static_cast<std::int16_t>(sensor::CloudEncoding::kXyz32));
  for (const storage::Evidence& item : change.evidence) {
    EXPECT_EQ(item.link_point, kPoint);
    EXPECT_EQ(item.map, MapId("here"));
  }
  ASSERT_TRUE(change.evidence[0].T_map_robot.has_value());
  EXPECT_THAT(*change.evidence[0].T_map_robot, PoseNear(Pose2{3.3, 0, 0}, 0.01, 1e-6)) << "where it was taken";
}

// As a candidate is seen: latch_distance, 1.7 m, before the door, which is at 6.6 s.
TEST(EvidenceKeeper, BeforeTheDoorTheImagesNearestToTheSightingAreKept) {
  PassedDoorLog log;
  const std::int64_t at_door = log.AddImage(9.9, Camera::kFront);
  const std::int64_t sighting = log.AddImage(6.5, Camera::kFront);
  const std::int64_t earlier = log.AddImage(5.0, Camera::kFront);
  log.AddImage(3.0, Camera::kFront);   // more than image_window before the sighting
  log.AddImage(10.5, Camera::kFront);  // behind the door
  EXPECT_THAT(KeepBefore(log).verdict.evidence, ElementsAre(sighting, earlier, at_door));
}

TEST(EvidenceKeeper, KeepsAFewImagesOfEachCamera) {
  PassedDoorLog log;
  for (int i = 0; i < 20; ++i) {
    log.AddImage(5.0 + 0.2 * i, Camera::kFront);
    log.AddImage(5.0 + 0.2 * i, Camera::kRear);
    log.AddCloud(5.0 + 0.2 * i);
  }
  const storage::DoorChange change = KeepBefore(log);
  EXPECT_THAT(change.evidence, SizeIs(6 + 6 + 1));
  EXPECT_THAT(change.verdict.evidence, SizeIs(6 + 6 + 1));
}

TEST(EvidenceKeeper, BehindTheDoorPosesAreInTheEnteredMap) {
  PassedDoorLog log;
  const std::int64_t at_report = log.AddImage(13.0, Camera::kFront);
  const std::int64_t just_behind = log.AddImage(11.0, Camera::kFront);
  log.AddImage(9.5, Camera::kFront);   // before the door
  log.AddImage(13.6, Camera::kFront);  // long after the report
  // There the door is at (2, 3), looking north.
  const storage::DoorChange change = KeepBehind(log, {MapId("there"), {2, 3, M_PI_2}, Eigen::Matrix3d::Zero()});
  EXPECT_THAT(change.verdict.evidence, ElementsAre(at_report, just_behind));
  ASSERT_THAT(change.evidence, SizeIs(2));
  EXPECT_EQ(change.evidence[0].map, MapId("there"));
  EXPECT_THAT(*change.evidence[0].T_map_robot, PoseNear(Pose2{2, 4.5, M_PI_2}, 1e-6, 1e-6));
  EXPECT_THAT(*change.evidence[1].T_map_robot, PoseNear(Pose2{2, 3.5, M_PI_2}, 1e-6, 1e-6));
}

TEST(EvidenceKeeper, ASightingKeepsWhatWasSeenAroundItsTime) {
  PassedDoorLog log;
  log.report().kind = sensor::DoorReport::Kind::kCandidate;
  const std::int64_t before = log.AddImage(7.1, Camera::kFront);
  const std::int64_t after = log.AddImage(12.0, Camera::kFront);
  log.AddImage(6.9, Camera::kFront);
  log.AddImage(13.1, Camera::kFront);
  EXPECT_THAT(KeepSighting(log).verdict.evidence, ElementsAre(after, before)) << "3 s before and after";
  const ViewWindow window = SightingWindow(log.Knowledge());
  EXPECT_EQ(window.time, PassedDoorLog::At(10.0));
  EXPECT_EQ(window.from, PassedDoorLog::At(7.0));
  EXPECT_EQ(window.to, PassedDoorLog::At(13.0));
}

// The reason of a candidate says whether there is evidence, before it is kept.
TEST(EvidenceKeeper, HasViewsSaysWhetherASightingWillHaveEvidence) {
  for (const double time : {5.0, 6.9, 7.0, 9.0, 13.0, 13.1}) {
    PassedDoorLog log;
    log.AddCloud(time);
    EXPECT_EQ(log.Scene().HasViews(SightingWindow(log.Knowledge())), !KeepSighting(log).evidence.empty()) << time;
  }
}

TEST(EvidenceKeeper, NothingWasRecordedNothingIsKept) {
  const PassedDoorLog log;
  EXPECT_THAT(KeepBefore(log).evidence, IsEmpty());
  EXPECT_THAT(KeepBehind(log, {MapId("there"), {}, Eigen::Matrix3d::Zero()}).evidence, IsEmpty());
  EXPECT_THAT(KeepSighting(log).verdict.evidence, IsEmpty());
}

TEST(ToNewMap, NamesTheMapByTheOptionsPrefix) {
  closure::DoorClosureOptions options;
  options.map_name = "Raum";
  const storage::NewMap map = ToNewMap(
      {.id = MapId("id"), .level = -1, .environment = Environment::kOutdoor, .slam_profile = "long-range"}, options);
  EXPECT_EQ(map.id, MapId("id"));
  EXPECT_EQ(map.name_prefix, "Raum");
  EXPECT_EQ(map.level, -1);
  EXPECT_EQ(map.environment, Environment::kOutdoor);
  EXPECT_EQ(map.slam_profile, "long-range");
}

}  // namespace
}  // namespace enfilade::server
