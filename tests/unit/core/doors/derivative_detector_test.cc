// SPDX-License-Identifier: Apache-2.0
#include "core/doors/derivative_detector.h"

#include <gmock/gmock.h>

#include <vector>

#include "tests/unit/core/doors/door_scan.h"

namespace enfilade::doors {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using Kind = DoorEvent::Kind;
using State = CriterionVerdict::State;

// A door of 36 degrees in direction `towards`, seen at a time in seconds.
sensor::LaserScan DoorAt(double seconds, double towards) {
  sensor::LaserScan scan = DoorScan(towards, 36.0);
  scan.time = DurationOf(seconds);
  return scan;
}

// Only far walls.
sensor::LaserScan OpenAt(double seconds) {
  sensor::LaserScan scan = DoorAt(seconds, 0.0);
  for (float& range : scan.ranges) range = 5.0F;
  return scan;
}

// With the environment's criterion out of reach, if not said otherwise.
class DerivativeDetectorTest : public ::testing::Test {
 protected:
  static DoorOptions Options() {
    DoorOptions options = *DoorPreset("original-yaml");
    options.environment.change = 1000.0;
    return options;
  }
  void Add(const sensor::LaserScan& scan, const Pose2& pose) { detector_.Add(scan, pose, events_); }
  // Three hits ahead from `seconds` on, at x = 0.
  void Latch(double seconds) {
    for (int i = 0; i < 3; ++i) Add(DoorAt(seconds + 0.6 * i, 0.0), {0, 0, 0});
  }
  std::vector<DoorEvent> Of(Kind kind) const {
    std::vector<DoorEvent> some;
    for (const DoorEvent& event : events_) {
      if (event.kind == kind) some.push_back(event);
    }
    return some;
  }

  DerivativeDetector detector_{Options()};
  std::vector<DoorEvent> events_;
};

TEST_F(DerivativeDetectorTest, ThreeHitsLatchADoorAtTheRobotsPose) {
  Add(DoorAt(0.0, 0.0), {0, 0, 0});
  Add(DoorAt(0.6, 0.0), {0.2, 0, 0});
  EXPECT_THAT(events_, IsEmpty());
  Add(DoorAt(1.2, 0.0), {0.4, 0, 0});
  ASSERT_THAT(events_, SizeIs(1));
  EXPECT_EQ(events_[0].kind, Kind::kLatched);
  EXPECT_EQ(events_[0].door, 1);
  EXPECT_EQ(events_[0].T_odom_door, (Pose2{0.4, 0, 0}));
  EXPECT_EQ(events_[0].ahead.state, State::kMet);
}

TEST_F(DerivativeDetectorTest, HitsMustBeApartInTimeAndWithinTheWindow) {
  for (int i = 0; i < 5; ++i) Add(DoorAt(0.1 * i, 0.0), {0, 0, 0});
  EXPECT_THAT(events_, IsEmpty()) << "half a second, one hit";
  Add(DoorAt(4.0, 0.0), {0, 0, 0});
  Add(DoorAt(4.6, 0.0), {0, 0, 0});
  EXPECT_THAT(events_, IsEmpty()) << "the first hit is more than 3 s old";
  Add(DoorAt(5.2, 0.0), {0, 0, 0});
  EXPECT_THAT(events_, SizeIs(1));
}

TEST_F(DerivativeDetectorTest, TheDoorBehindMakesItAPassage) {
  Latch(0.0);
  for (int i = 0; i < 3; ++i) Add(DoorAt(4.0 + 0.2 * i, M_PI), {3.0, 0, 0.1});
  ASSERT_THAT(Of(Kind::kPassage), SizeIs(1));
  const DoorEvent passage = Of(Kind::kPassage)[0];
  EXPECT_EQ(passage.door, 1);
  EXPECT_EQ(passage.T_odom_door, (Pose2{0, 0, 0})) << "where it was latched";
  EXPECT_EQ(passage.behind.state, State::kMet);
  EXPECT_THAT(passage.behind.reason, HasSubstr("3.0 m on"));
  detector_.Finish(events_);
  EXPECT_THAT(Of(Kind::kCandidate), IsEmpty()) << "a passed door is not a candidate as well";
}

TEST_F(DerivativeDetectorTest, TheDoorBehindMustBeAtTheRightDistanceAndHeading) {
  struct Case {
    const char* what;
    Pose2 pose;
    bool passage;
  };
  const std::vector<Case> cases = {
      {"too near", {1.4, 0, 0}, false},
      {"near enough", {1.6, 0, 0}, true},
      {"far enough", {4.9, 0, 0}, true},
      {"too far", {5.1, 0, 0}, false},
      {"turned a little", {3.0, 0, 0.5}, true},
      {"turned away", {3.0, 0, 0.6}, false},
      {"turned the other way", {3.0, 0, -0.6}, false},
  };
  for (const Case& one : cases) {
    DerivativeDetector detector(Options());
    std::vector<DoorEvent> events;
    for (int i = 0; i < 3; ++i) detector.Add(DoorAt(0.6 * i, 0.0), {0, 0, 0}, events);
    for (int i = 0; i < 3; ++i) detector.Add(DoorAt(4.0 + 0.2 * i, M_PI), one.pose, events);
    EXPECT_EQ(events.back().kind == Kind::kPassage, one.passage) << one.what;
  }
}

TEST_F(DerivativeDetectorTest, AtTheTimeLimitALatchedDoorIsACandidateAndAnotherAttemptStarts) {
  Latch(0.0);
  Add(OpenAt(14.9), {0, 0, 0});
  EXPECT_THAT(Of(Kind::kCandidate), IsEmpty());
  Add(OpenAt(15.1), {1, 0, 0});
  ASSERT_THAT(Of(Kind::kCandidate), SizeIs(1));
  const DoorEvent candidate = Of(Kind::kCandidate)[0];
  EXPECT_EQ(candidate.door, 1);
  EXPECT_EQ(candidate.T_odom_door, (Pose2{0, 0, 0}));
  EXPECT_EQ(candidate.T_odom_robot, (Pose2{1, 0, 0}));
  EXPECT_THAT(candidate.reason, HasSubstr("15 s"));
  for (int i = 0; i < 3; ++i) Add(DoorAt(20.0 + 0.6 * i, 0.0), {6, 0, 0});
  ASSERT_THAT(Of(Kind::kLatched), SizeIs(2));
  EXPECT_EQ(Of(Kind::kLatched)[1].door, 2);
}

TEST_F(DerivativeDetectorTest, TwoCandidatesAreApart) {
  Latch(0.0);
  Add(OpenAt(15.1), {0, 0, 0});
  for (int i = 0; i < 3; ++i) Add(DoorAt(20.0 + 0.6 * i, 0.0), {1.9, 0, 0});
  EXPECT_THAT(Of(Kind::kLatched), SizeIs(1)) << "1.9 m from the first one";
}

TEST_F(DerivativeDetectorTest, FinishReportsALatchedDoorOnce) {
  detector_.Finish(events_);
  EXPECT_THAT(events_, IsEmpty());
  Latch(0.0);
  detector_.Finish(events_);
  EXPECT_THAT(Of(Kind::kCandidate), SizeIs(1));
  detector_.Finish(events_);
  EXPECT_THAT(Of(Kind::kCandidate), SizeIs(1));
}

// The box around the scan grows by 3 m on all sides.
TEST(DerivativeDetectorEnvironment, AChangedBoxAndTheDoorAheadMakeAPassage) {
  for (const double change : {0.5, 2.0}) {
    DoorOptions options = *DoorPreset("original-yaml");
    options.environment.change = change;
    DerivativeDetector detector(options);
    std::vector<DoorEvent> events;
    detector.Add(OpenAt(0.0), {0, 0, 0}, events);
    for (int i = 0; i < 3; ++i) detector.Add(DoorAt(0.1 + 0.6 * i, 0.0), {0, 0, 0}, events);
    sensor::LaserScan hall = OpenAt(4.0);
    for (float& range : hall.ranges) range = 8.0F;
    detector.Add(hall, {1, 0, 0}, events);
    const bool passed = events.back().kind == Kind::kPassage;
    EXPECT_EQ(passed, change < 1.5) << change << ": half of 3 m";
    if (passed) {
      EXPECT_THAT(events.back().environment.reason, HasSubstr("4 sides of the box changed"));
    }
  }
}

}  // namespace
}  // namespace enfilade::doors
