// SPDX-License-Identifier: Apache-2.0
#include "core/doors/door_detector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <string>

#include "client/simulator/campus/campus_yaml.h"
#include "client/simulator/simulation.h"
#include "client/simulator/simulation_files.h"
#include "core/sensor/scan_pairing.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"

namespace enfilade::doors {
namespace {

using ::testing::HasSubstr;
using Kind = DoorEvent::Kind;

struct Driven {
  std::vector<sensor::PairedScan> scans;
  simulator::GroundTruth truth;
};

Driven DriveThrough(const simulator::Campus& campus, const std::string& robot,
                    const simulator::SimulationOptions& options = {}) {
  const auto world = std::make_shared<const simulator::World>(campus);
  absl::StatusOr<simulator::Drive> drive = simulator::SimulateDrive(world, robot, options);
  EXPECT_OK(drive.status());
  Driven driven;
  driven.truth = drive->truth;
  Pose2 T_odom_robot;
  for (simulator::SimulatedRecord& record : drive->records) {
    if (const auto* odometry = std::get_if<sensor::Odometry>(&record.payload)) T_odom_robot = odometry->T_odom_robot;
    if (auto* scan = std::get_if<sensor::LaserScan>(&record.payload))
      driven.scans.push_back({0, std::move(*scan), T_odom_robot});
  }
  return driven;
}

Driven Drive(const char* yaml, const simulator::SimulationOptions& options = {}) {
  const absl::StatusOr<simulator::Campus> campus = simulator::ParseCampus(yaml);
  EXPECT_OK(campus.status());
  return DriveThrough(*campus, "r", options);
}

std::vector<DoorEvent> Detect(const std::vector<sensor::PairedScan>& scans, const DoorOptions& options = {}) {
  DoorDetector detector(options);
  std::vector<DoorEvent> events;
  for (const sensor::PairedScan& scan : scans) {
    for (const DoorEvent& event : detector.Add(scan.scan, *scan.T_odom_robot)) events.push_back(event);
  }
  for (const DoorEvent& event : detector.Finish()) events.push_back(event);
  return events;
}

std::vector<DoorEvent> Only(const std::vector<DoorEvent>& events, Kind kind) {
  std::vector<DoorEvent> some;
  for (const DoorEvent& event : events) {
    if (event.kind == kind) some.push_back(event);
  }
  return some;
}

constexpr const char* kStraight = R"(
areas:
  - {id: a, rect: [0, 0, 6, 5], doors: [{id: d, side: east, at: 2.5, width: 1.0}]}
  - {id: b, rect: [6, 0, 7, 5]}
robots: [{id: r, route: [[1.5, 2.5], {door: d}, [10, 2.5]]}]
)";

TEST(DoorDetector, ReportsAPassageWithThePlaceOfTheDoor) {
  const Driven driven = Drive(kStraight);
  const std::vector<DoorEvent> events = Detect(driven.scans);
  const auto passages = Only(events, Kind::kPassage);
  ASSERT_EQ(passages.size(), 1U);
  const DoorEvent& passage = passages[0];
  // Odometry starts where the robot does, at (1.5, 2.5), heading east.
  EXPECT_THAT(passage.T_odom_door, enfilade::testing::PoseNear(Pose2{4.5, 0.0, 0.0}, 0.25, 0.15));
  EXPECT_NEAR(passage.width, 1.0, 0.12);
  EXPECT_NEAR(ToSeconds(passage.door_time - driven.truth.passages[0].time), 0.0, 0.5);
  EXPECT_TRUE(passage.ahead.met()) << passage.ahead.reason;
  EXPECT_TRUE(passage.behind.met()) << passage.behind.reason;
  const auto latched = Only(events, Kind::kLatched);
  ASSERT_EQ(latched.size(), 1U) << "before it is driven through";
  EXPECT_EQ(latched[0].door, passage.door);
  EXPECT_LT(latched[0].time, driven.truth.passages[0].time);
  EXPECT_TRUE(Only(events, Kind::kCandidate).empty()) << "it was driven through";
}

// Two scans, each 0.3 m after the one before, see the door ahead. Of a robot that scans often two are too few.
TEST(DoorDetector, TwoScansFarFromEachOtherSeeADoor) {
  simulator::SimulationOptions sparse;
  sparse.scan_hz = 2.0;
  const char* kNearTheDoor = R"(
areas:
  - {id: a, rect: [0, 0, 6, 5], doors: [{id: d, side: east, at: 2.5, width: 1.0}]}
  - {id: b, rect: [6, 0, 7, 5]}
robots: [{id: r, route: [[5.05, 2.5], {door: d}, [10, 2.5]]}]
)";
  const Driven driven = Drive(kNearTheDoor, sparse);
  DoorOptions each_once;
  each_once.gap.sparse = 99.0;
  const auto often = Only(Detect(driven.scans, each_once), Kind::kPassage);
  const auto passages = Only(Detect(driven.scans), Kind::kPassage);
  ASSERT_EQ(passages.size(), 1U);
  EXPECT_THAT(passages[0].ahead.reason, HasSubstr("2 scans"));
  EXPECT_TRUE(often.empty() || !often[0].ahead.met());
}

TEST(DoorDetector, ThePresetsOfMapManagerReportItToo) {
  const Driven driven = Drive(kStraight);
  for (const char* preset : {"original-yaml", "original-code"}) {
    ASSERT_OK_AND_ASSIGN(const DoorOptions options, DoorPreset(preset));
    const std::vector<DoorEvent> events = Detect(driven.scans, options);
    EXPECT_EQ(Only(events, Kind::kLatched).size(), 1U) << preset;
    EXPECT_EQ(Only(events, Kind::kPassage).size(), 1U) << preset;
  }
}

TEST(DoorDetector, ADoorThatIsSeenAndNotPassedBecomesACandidate) {
  const Driven driven = Drive(R"(
areas:
  - {id: a, rect: [0, 0, 6, 5], doors: [{id: d, side: east, at: 2.5, width: 1.0}]}
  - {id: b, rect: [6, 0, 7, 5]}
robots: [{id: r, route: [[1.5, 2.5], [4.6, 2.5], {wait: 1}, {turn_to_deg: 180}, [1.2, 2.5], {wait: 16}]}]
)");
  for (const std::string& preset : DoorPresetNames()) {
    ASSERT_OK_AND_ASSIGN(const DoorOptions options, DoorPreset(preset));
    const std::vector<DoorEvent> events = Detect(driven.scans, options);
    EXPECT_TRUE(Only(events, Kind::kPassage).empty()) << preset;
    const auto candidates = Only(events, Kind::kCandidate);
    ASSERT_EQ(candidates.size(), 1U) << preset;
    const auto latched = Only(events, Kind::kLatched);
    ASSERT_EQ(latched.size(), 1U) << preset;
    EXPECT_EQ(candidates[0].T_odom_door, latched[0].T_odom_robot) << "the robot's pose when it was latched";
    EXPECT_EQ(candidates[0].door_time, latched[0].time);
    EXPECT_LT(std::abs(candidates[0].T_odom_door.yaw), 0.2) << "looking at the door";
    if (options.method != DoorMethod::kGap) continue;
    ASSERT_TRUE(candidates[0].T_odom_gap) << preset;
    EXPECT_NEAR(candidates[0].T_odom_gap->x, 6.0 - 1.5, 0.15);  // the odometry began at the first waypoint
    EXPECT_NEAR(candidates[0].T_odom_gap->y, 0.0, 0.15);
    EXPECT_NEAR(candidates[0].T_odom_gap->yaw, 0.0, 0.2) << "through the door";
  }
}

// What looks like a door from afar, and proves to be none when the robot has gone through: its sightings are forgotten
// then, so that a candidate of it would have none.
TEST(DoorDetector, AGapThatTheRobotHasGoneThroughIsNoCandidate) {
  ASSERT_OK_AND_ASSIGN(const simulator::Campus campus, simulator::LoadCampus("suites:2019"));
  const std::vector<DoorEvent> events = Detect(DriveThrough(campus, "robot").scans);
  EXPECT_FALSE(Only(events, Kind::kPassage).empty());
  const auto candidates = Only(events, Kind::kCandidate);
  EXPECT_FALSE(candidates.empty());
  for (const DoorEvent& candidate : candidates) {
    EXPECT_THAT(candidate.ahead.reason, ::testing::Not(::testing::StartsWith("0 scans"))) << candidate.door;
  }
}

TEST(DoorDetector, ThingsThatStandAboutAreNotADoor) {
  const Driven driven = Drive(R"(
areas: [{id: a, rect: [0, 0, 12, 8]}]
boxes: [{rect: [5.6, 2.6, 0.6, 0.6]}, {rect: [5.6, 4.4, 0.6, 0.6]}]
robots: [{id: r, route: [[1.5, 3.8], [10, 3.8]]}]
)");
  EXPECT_TRUE(Only(Detect(driven.scans), Kind::kPassage).empty());
}

TEST(DoorDetector, ACorridorsWidthIsNotADoor) {
  const Driven driven = Drive(R"(
areas:
  - {id: c, kind: corridor, rect: [0, 0, 16, 1.9],
     doors: [{id: d1, side: north, at: 4}, {id: d2, side: north, at: 6}, {id: d3, side: south, at: 9}]}
  - {id: a, rect: [2, 1.9, 3, 4]}
  - {id: b, rect: [5, 1.9, 3, 4]}
  - {id: e, rect: [7, -4, 4, 4]}
robots: [{id: r, route: [[1.2, 0.95], [14.5, 0.95]]}]
)");
  EXPECT_TRUE(Only(Detect(driven.scans), Kind::kPassage).empty());
}

TEST(DoorDetector, ACorridorBetweenStaggeredOpenDoorsIsNotADoor) {
  const Driven driven = Drive(R"(
areas:
  - {id: c, kind: corridor, rect: [0, 0, 16, 1.8],
     doors: [{id: d1, side: north, at: 7.2, width: 1.6}, {id: d2, side: south, at: 8.6, width: 1.6},
             {id: d3, side: north, at: 10.4, width: 1.4}]}
  - {id: a, rect: [5, 1.8, 4, 4]}
  - {id: b, rect: [6.5, -4, 4, 4]}
  - {id: e, rect: [9, 1.8, 4, 4]}
robots: [{id: r, route: [[1.2, 0.9], [14.5, 0.9]]}]
)");
  EXPECT_TRUE(Only(Detect(driven.scans), Kind::kPassage).empty());
}

TEST(DoorDetector, ADoorAcrossACorridorIsADoor) {
  const Driven driven = Drive(R"(
areas:
  - {id: a, kind: corridor, rect: [0, 0, 8, 2], doors: [{id: d, side: east, at: 1.0, width: 0.9}]}
  - {id: b, kind: corridor, rect: [8, 0, 8, 2]}
robots: [{id: r, route: [[1.5, 1.0], {door: d}, [14, 1.0]]}]
)");
  EXPECT_EQ(Only(Detect(driven.scans), Kind::kPassage).size(), 1U);
}

TEST(DoorDetector, AWideDoorBesideAPaneOfGlassIsADoor) {
  const Driven driven = Drive(R"(
areas:
  - {id: a, rect: [0, 0, 6, 7],
     doors: [{id: d, side: east, at: 3.5, width: 1.6}, {id: p, side: east, at: 5.0, width: 1.0, state: glass}]}
  - {id: b, rect: [6, 0, 7, 7]}
robots: [{id: r, route: [[1.5, 3.5], {door: d}, [10, 3.5]]}]
)");
  EXPECT_EQ(Only(Detect(driven.scans), Kind::kPassage).size(), 1U);
}

TEST(DoorDetector, AFrontOnlyScannerFindsDoorsAndDropsWhatItCannotJudge) {
  simulator::SimulationOptions options;
  options.scanner.field_of_view = M_PI;
  options.scanner.beams = 181;
  const Driven driven = Drive(kStraight, options);
  const auto passages = Only(Detect(driven.scans), Kind::kPassage);
  ASSERT_EQ(passages.size(), 1U);
  EXPECT_EQ(passages[0].environment.state, CriterionVerdict::State::kDropped) << passages[0].environment.reason;
  EXPECT_THAT(passages[0].environment.reason, HasSubstr("different things"));

  ASSERT_OK_AND_ASSIGN(DoorOptions original, DoorPreset("original-yaml"));
  original.derivative.turned_stands_for_behind = false;
  const auto candidates = Only(Detect(driven.scans, original), Kind::kCandidate);
  ASSERT_EQ(candidates.size(), 1U) << "without the criterion behind, the derivative method sees no passage here";
  EXPECT_EQ(candidates[0].behind.state, CriterionVerdict::State::kDropped);
  EXPECT_THAT(candidates[0].behind.reason, HasSubstr("does not look back"));
}

// Scans with fewer beams than the window, all infinite, NaN, changing sizes.
TEST(DoorDetector, AcceptsAnyScan) {
  std::mt19937 random(7);
  for (const std::string& preset : DoorPresetNames()) {
    ASSERT_OK_AND_ASSIGN(const DoorOptions options, DoorPreset(preset));
    DoorDetector detector(options);
    for (int i = 0; i < 400; ++i) {
      sensor::LaserScan scan;
      scan.time = i * kNsPerSecond / 5;
      scan.angle_min = -M_PI;
      const std::size_t beams = 1 + random() % 400;
      scan.angle_increment = 2.0 * M_PI / static_cast<double>(beams);
      scan.range_max = 20.0F;
      for (std::size_t k = 0; k < beams; ++k) {
        const unsigned kind = random() % 8;
        const float range = static_cast<float>(random() % 1000) / 100.0F;
        scan.ranges.push_back(kind == 0   ? std::numeric_limits<float>::quiet_NaN()
                              : kind == 1 ? std::numeric_limits<float>::infinity()
                              : kind == 2 ? -1.0F
                                          : range);
      }
      if (i % 50 == 0) scan.ranges.assign(beams, std::numeric_limits<float>::infinity());
      if (i % 50 == 1) scan.ranges.assign(beams, std::numeric_limits<float>::quiet_NaN());
      detector.Add(scan, {0.05 * i, 0.0, 0.0});
    }
    sensor::LaserScan bad;
    EXPECT_TRUE(detector.Add(bad, {}).empty()) << "no beams";
    sensor::LaserScan good;
    good.time = 1000 * kNsPerSecond;
    good.angle_increment = 0.1;
    good.range_max = 5.0F;
    good.ranges = {1.0F};
    EXPECT_TRUE(detector.Add(good, {NAN, 0.0, 0.0}).empty()) << "no pose";
  }
}

TEST(DoorDetector, ContinuesFromItsStateWithTheSameEvents) {
  const Driven driven = Drive(kStraight);
  for (const std::string& preset : DoorPresetNames()) {
    ASSERT_OK_AND_ASSIGN(const DoorOptions options, DoorPreset(preset));
    DoorDetector detector(options);
    std::vector<DoorEvent> events;
    for (std::size_t i = 0; i < driven.scans.size(); ++i) {
      if (i % 7 == 3) {
        const std::string state = detector.Serialize();
        ASSERT_OK_AND_ASSIGN(DoorDetector restored, DoorDetector::Restore(options, state));
        ASSERT_EQ(restored.Serialize(), state);
        detector = std::move(restored);
      }
      for (const DoorEvent& event : detector.Add(driven.scans[i].scan, *driven.scans[i].T_odom_robot)) {
        events.push_back(event);
      }
    }
    for (const DoorEvent& event : detector.Finish()) events.push_back(event);
    EXPECT_EQ(events, Detect(driven.scans, options)) << preset;
  }
}

TEST(DoorDetector, RefusesInvalidStates) {
  DoorDetector detector{DoorOptions{}};
  const std::string state = detector.Serialize();
  ASSERT_OK_AND_ASSIGN(const DoorOptions original, DoorPreset("original-yaml"));
  EXPECT_STATUS(DoorDetector::Restore(original, state), absl::StatusCode::kDataLoss, HasSubstr("method"));
  EXPECT_STATUS(DoorDetector::Restore({}, "\x09"), absl::StatusCode::kDataLoss, HasSubstr("version 9"));
  EXPECT_STATUS(DoorDetector::Restore({}, state + "x"), absl::StatusCode::kDataLoss, HasSubstr("trailing"));
  for (const std::size_t size : {std::size_t{0}, std::size_t{5}, state.size() / 2, state.size() - 1}) {
    EXPECT_FALSE(DoorDetector::Restore({}, state.substr(0, size)).ok()) << size;
  }
}

}  // namespace
}  // namespace enfilade::doors
