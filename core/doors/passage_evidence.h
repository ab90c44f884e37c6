// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/doors/door_event.h"
#include "core/doors/door_options.h"
#include "core/doors/jamb_walls.h"

namespace enfilade::doors {

// What speaks for and against a door at a narrow place that the robot has driven through.
struct PassageEvidence {
  CriterionVerdict ahead;
  CriterionVerdict behind;
  CriterionVerdict environment;
  // Share of the ground that is out of sight from the other side, the larger of both sides; negative: unknown.
  double hidden = -1.0;
  JambWalls walls;
  double parallel = 0.0;   // m, of ParallelSurfaces
  bool way_round = false;  // on observed free ground, with the wall's whole line closed

  int met() const { return (ahead.met() ? 1 : 0) + (behind.met() ? 1 : 0) + (environment.met() ? 1 : 0); }
};

struct PassageVerdict {
  bool passage = false;
  std::string reason;  // what speaks for it, or the first thing against it
};

// A passage leads through a gap in a wall: the criterion "behind" and as many others as required are met, the posts are
// the ends of a wall that is long and slender enough, and no walls run beside the way at both posts. Against it speak
// ground that stays in sight, unless the wall is long or closes a corridor, and a way round, unless the wall is long
// and the environment has changed, or the wall is far more slender than required.
PassageVerdict JudgePassage(const PassageEvidence& evidence, const DoorOptions& options);

}  // namespace enfilade::doors
