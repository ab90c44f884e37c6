// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "client/simulator/simulation.h"
#include "core/sensor/record.h"
#include "core/sensor/session_entry.h"

namespace enfilade::testing {

// A robot's drive through a simulated campus, split into sessions where core/doors detects passages, as the robot's
// agent does: each session ends with the report, and the next one begins with the next record.
struct DrivenSession {
  std::vector<sensor::Record> log;
  std::vector<std::string> contents;  // of the log's images and clouds
  std::vector<std::string>
      doors;                // of the campus: "candidate", or the door's id for a passage, in the order of reports
  std::string area;         // in which it ends
  simulator::TruePose end;  // the robot's pose at its last scan
};

struct DoorDriveOptions {
  std::string campus = "figure1";  // or the text of a campus file
  std::string robot = "r1";
  simulator::SimulationOptions simulation;
};

// Fails the test if the campus is invalid.
std::vector<DrivenSession> DriveThroughDoors(const DoorDriveOptions& options);
// Options with images and clouds near doors.
DoorDriveOptions WithImagesAndClouds();
// Two rooms, west (10 m x 8 m) and east, joined by the doors "south" and "north". Robot "r" looks at "north" from the
// west, goes through "south", comes back by "north" and goes through "south" again.
std::string TwoRooms();

}  // namespace enfilade::testing
