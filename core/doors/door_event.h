// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/base/time.h"
#include "core/geometry/pose2.h"

namespace enfilade::doors {

// The state of one of the three criteria.
struct CriterionVerdict {
  enum class State : std::uint8_t {
    kOpen = 0,  // not met (yet)
    kMet = 1,
    kDropped = 2,  // cannot be judged with this scanner, or here
  };
  State state = State::kOpen;
  std::string reason;  // as text, with figures

  bool met() const { return state == State::kMet; }
  friend bool operator==(const CriterionVerdict&, const CriterionVerdict&) = default;
};

struct DoorEvent {
  enum class Kind : std::uint8_t {
    kLatched = 1,    // a door is seen ahead: keep the present image, cloud and pose, for a candidate
    kCandidate = 2,  // the latched door was not driven through: a link point candidate
    kPassage = 3,    // the robot has driven through a door
  };
  Kind kind = Kind::kLatched;
  std::int64_t door = 0;  // counts latched doors from 1; a candidate or passage has the number of its latch (0: none)
  TimeNs time = 0;        // of the scan that decided it
  Pose2 T_odom_robot;     // then
  // The pose at the door: where the robot was when it was latched; for a passage of the gap method the middle of the
  // door, looking along the way through.
  Pose2 T_odom_door;
  TimeNs door_time = 0;  // when the robot was there (kPassage: when it crossed, as near as is known)
  double width = 0.0;    // m between the posts; 0: unknown
  // kLatched and kCandidate: the middle between the posts, looking along the way through; unset: somewhere ahead.
  std::optional<Pose2> T_odom_gap = {};
  CriterionVerdict ahead;
  CriterionVerdict behind;
  CriterionVerdict environment;
  std::string reason;

  friend bool operator==(const DoorEvent&, const DoorEvent&) = default;
};

inline const char* NameOf(DoorEvent::Kind kind) {
  return kind == DoorEvent::Kind::kLatched ? "latched" : kind == DoorEvent::Kind::kCandidate ? "candidate" : "passage";
}

}  // namespace enfilade::doors
