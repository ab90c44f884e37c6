// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/doors/door_event.h"
#include "core/doors/door_options.h"
#include "core/doors/jamb_walls.h"

namespace enfilade::doors {

// What is known of a narrow place that the robot has driven through.
struct PassageEvidence {
  CriterionVerdict ahead;
  CriterionVerdict behind;
  CriterionVerdict environment;
  // Share of the ground out of sight from the other side, the larger one; negative: cannot be told.
  double hidden = -1.0;
  JambWalls walls;
  double parallel = 0.0;   // m, of ParallelSurfaces
  bool way_round = false;  // on observed free ground, the wall's whole line taken as closed

  int met() const { return (ahead.met() ? 1 : 0) + (behind.met() ? 1 : 0) + (environment.met() ? 1 : 0); }
};

struct PassageVerdict {
  bool passage = false;
  std::string reason;  // what speaks for it, or the first thing that speaks against it
};

// A passage is one through a gap in a wall: the criterion behind and as many others as are asked for hold, the posts
// are the ends of a wall that is long enough and slender, and no walls run beside the way at both. Against it speak
// ground that stays in sight, unless the wall is long or closes a corridor, and a way round, unless the wall is long
// and the environment has changed, or it is far more slender than asked for.
PassageVerdict JudgePassage(const PassageEvidence& evidence, const DoorOptions& options);

}  // namespace enfilade::doors
