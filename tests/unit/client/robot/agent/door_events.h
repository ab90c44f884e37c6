// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "client/robot/agent/state_machine.h"
#include "core/base/time.h"

namespace enfilade::robot {

inline TimeNs AfterStart(double seconds) { return static_cast<TimeNs>(seconds * 1e9) + kNsPerSecond; }

inline Moved MovedTo(double seconds, double x) { return {AfterStart(seconds), {x, 0.0, 0.0}}; }

// A door across the x axis.
inline DoorDetected Door(doors::DoorEvent::Kind kind, std::int64_t number, double seconds, double door_seconds,
                         double door_x) {
  doors::DoorEvent event;
  event.kind = kind;
  event.door = number;
  event.time = AfterStart(seconds);
  event.T_odom_robot = {door_x + 1.0, 0.0, 0.0};
  event.door_time = AfterStart(door_seconds);
  event.T_odom_door = {door_x, 0.0, 0.0};
  event.width = 1.0;
  event.reason = "as the test says";
  return {event};
}
inline DoorDetected Latched(std::int64_t number, double seconds) {
  return Door(doors::DoorEvent::Kind::kLatched, number, seconds, seconds, 0.0);
}
inline DoorDetected Candidate(std::int64_t number, double seconds, double door_seconds) {
  return Door(doors::DoorEvent::Kind::kCandidate, number, seconds, door_seconds, 0.0);
}
inline DoorDetected Passage(std::int64_t number, double seconds, double door_seconds, double door_x) {
  return Door(doors::DoorEvent::Kind::kPassage, number, seconds, door_seconds, door_x);
}

}  // namespace enfilade::robot
