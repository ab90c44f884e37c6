// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/base/binary.h"
#include "core/base/time.h"
#include "core/doors/narrows.h"
#include "core/geometry/pose2.h"

namespace enfilade::doors {

// A narrow place that was seen ahead.
struct DoorTrack {
  Narrows narrows;
  int hits = 0;    // scans that saw it
  int weight = 0;  // of these scans: one far from the scan before it counts twice
  TimeNs last_hit = 0;
  std::int64_t door = 0;  // its number once latched; 0: not yet
  bool reported = false;  // as a candidate, or not to be
  TimeNs latch_time = 0;
  Pose2 T_odom_latch;
  double crossed_at = -1.0;  // travelled, m, where the path crossed it; -1: not yet
};

void PutTrack(BinaryWriter& writer, const DoorTrack& track);
DoorTrack GetTrack(BinaryReader& reader);

}  // namespace enfilade::doors
