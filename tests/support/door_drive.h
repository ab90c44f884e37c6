// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "client/simulator/simulation.h"
#include "core/sensor/record.h"
#include "core/sensor/session_entry.h"

namespace enfilade::testing {

// A robot's drive through a simulated campus, cut into sessions where core/doors finds passages, as the robot's agent
// does it: each ends with the report, and the next one begins with the next record.
struct DrivenSession {
  std::vector<sensor::Record> log;
  std::vector<std::string> contents;  // of the log's images and clouds
  std::vector<std::string>
      doors;                // of the campus: "candidate", or the door's id for a passage, in the order of reports
  std::string area;         // where it ends
  simulator::TruePose end;  // the robot's, at its last scan
};

struct DoorDriveOptions {
  std::string campus = "figure1";  // or a campus as text
  std::string robot = "r1";
  simulator::SimulationOptions simulation;
};

// Images and clouds near doors. Fails the test where the campus is none.
std::vector<DrivenSession> DriveThroughDoors(const DoorDriveOptions& options);
DoorDriveOptions WithImagesAndClouds();
// Two rooms, west (10 m x 8 m) and east, joined by the doors "south" and "north". Robot "r" looks at "north" from the
// west, goes through "south", comes back by "north" and goes through "south" again.
std::string TwoRooms();

}  // namespace enfilade::testing
