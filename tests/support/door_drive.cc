// SPDX-License-Identifier: Apache-2.0
#include "tests/support/door_drive.h"

#include <algorithm>
#include <utility>

#include "client/simulator/campus/campus_yaml.h"
#include "client/simulator/simulation_files.h"
#include "core/doors/door_detector.h"
#include "tests/support/status_assertions.h"

namespace enfilade::testing {
namespace {

sensor::DoorReport ToReport(const doors::DoorEvent& event) {
  sensor::DoorReport report;
  report.time = event.time;
  report.kind = event.kind == doors::DoorEvent::Kind::kPassage ? sensor::DoorReport::Kind::kPassage
                                                               : sensor::DoorReport::Kind::kCandidate;
  report.door_time = event.door_time;
  report.T_odom_door = event.T_odom_door;
  report.width = event.width;
  report.reason = event.reason;
  return report;
}

// The passage that happened last before `time`.
std::string DoorBefore(const simulator::GroundTruth& truth, TimeNs time) {
  std::string door = "none";
  for (const simulator::TruePassage& passage : truth.passages) {
    if (passage.time <= time) door = passage.door;
  }
  return door;
}

}  // namespace

DoorDriveOptions WithImagesAndClouds() {
  DoorDriveOptions options;
  options.simulation.image_hz = 2.0;
  options.simulation.cloud_hz = 2.0;
  options.simulation.near_doors = 4.0;
  return options;
}

std::string TwoRooms() {
  return R"(campus: two-rooms
textures:
  plaster: {brightness: 0.65, contrast: 0.9}
areas:
  - id: west
    rect: [0, 0, 10, 8]
    texture: plaster
    doors: [{id: south, side: east, at: 1.5, width: 1.0}, {id: north, side: east, at: 6.5, width: 1.0}]
  - {id: east, rect: [10, 0, 9, 8], texture: plaster}
boxes:
  - {rect: [0.3, 6.6, 0.6, 1.2], height: 1.9}
  - {rect: [3.0, 0.3, 1.6, 0.8], height: 1.2}
  - {rect: [6.0, 3.6, 0.8, 0.8], yaw_deg: 30, height: 1.1}
  - {rect: [13.0, 7.0, 2.4, 0.7], height: 1.9}
  - {rect: [17.6, 2.0, 0.9, 1.6], height: 1.0}
  - {rect: [13.5, 3.4, 0.8, 0.8], yaw_deg: 45, height: 0.9}
pillars: [{at: [4.0, 6.0], radius: 0.2}, {at: [18.4, 6.6], radius: 0.25}]
robots:
  - id: r
    route:
      - [2.5, 3.0]
      - [4.8, 5.0]
      - [6.4, 6.5]
      - [8.6, 6.5]
      - {wait: 2}
      - {turn_to_deg: 180}
      - [6.0, 5.6]
      - [5.0, 2.6]
      - [7.0, 1.5]
      - {door: south}
      - [12.5, 1.5]
      - [15.5, 2.5]
      - [15.0, 5.8]
      - [12.5, 6.5]
      - {door: north}
      - [7.5, 6.4]
      - [5.0, 4.6]
      - [5.4, 2.2]
      - [7.5, 1.5]
      - {door: south}
      - [13.0, 1.6]
      - [15.0, 2.2]
)";
}

std::vector<DrivenSession> DriveThroughDoors(const DoorDriveOptions& options) {
  const bool is_text = options.campus.find('\n') != std::string::npos;
  const auto campus = is_text ? simulator::ParseCampus(options.campus) : simulator::LoadCampus(options.campus);
  EXPECT_OK(campus);
  const auto world = std::make_shared<const simulator::World>(*campus);
  const auto drive = simulator::SimulateDrive(world, options.robot, options.simulation);
  EXPECT_OK(drive);
  std::vector<DrivenSession> sessions(1);
  doors::DoorDetector detector{doors::DoorOptions()};
  Pose2 T_odom_robot;
  for (const simulator::SimulatedRecord& simulated : drive->records) {
    if (const auto* odometry = std::get_if<sensor::Odometry>(&simulated.payload)) T_odom_robot = odometry->T_odom_robot;
    sensor::Record record;
    record.sequence = static_cast<std::int64_t>(sessions.back().log.size()) + 1;
    std::visit([&](const auto& payload) { record.payload = payload; }, simulated.payload);
    sessions.back().log.push_back(record);
    if (!simulated.content.empty()) sessions.back().contents.push_back(simulated.content);
    const auto* scan = std::get_if<sensor::LaserScan>(&simulated.payload);
    if (scan == nullptr) continue;
    const auto pose = std::find_if(drive->truth.poses.begin(), drive->truth.poses.end(),
                                   [&](const simulator::TruePose& p) { return p.time >= scan->time; });
    if (pose != drive->truth.poses.end()) {
      sessions.back().end = *pose;
      sessions.back().area = pose->area;
    }
    for (const doors::DoorEvent& event : detector.Add(*scan, T_odom_robot)) {
      if (event.kind == doors::DoorEvent::Kind::kLatched) continue;
      DrivenSession& session = sessions.back();
      session.log.push_back({static_cast<std::int64_t>(session.log.size()) + 1, ToReport(event)});
      if (event.kind == doors::DoorEvent::Kind::kCandidate) {
        session.doors.push_back("candidate");
        continue;
      }
      session.doors.push_back(DoorBefore(drive->truth, event.time));
      sessions.emplace_back();
    }
  }
  return sessions;
}

}  // namespace enfilade::testing
