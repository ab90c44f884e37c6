// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

// How a plan differs from what it was. What was moved counts as removed and added.
struct PlanChanges {
  int walls_added = 0;
  int walls_removed = 0;
  int walls_changed = 0;  // in the same place, with another thickness or confidence
  int doors_added = 0;
  int doors_removed = 0;
  bool scale_changed = false;
  bool outlines_changed = false;  // a room's name, or a shaft

  bool AnyWallOrDoor() const { return walls_added + walls_removed + walls_changed + doors_added + doors_removed > 0; }
  bool Any() const { return AnyWallOrDoor() || scale_changed || outlines_changed; }
};

// "2 walls added, 1 removed; 1 door added; another scale"; "nothing" if nothing differs.
std::string Describe(const PlanChanges& changes);

struct EditedPlan {
  PlanGraph plan;
  PlanChanges changes;
  std::vector<std::string> warnings;  // for people: what looks like a mistake
};

// The plan that a person has drawn, changing `before`, as a planar graph (IsPlanar) with its rooms.
//
// * Walls and doors of `before` that are in `drawn` as well stay where they are, to the last bit. A millionth of the
//   plan's size is no difference: programs round coordinates.
// * What is new is joined: its ends move onto the corner nearest to them, else onto the nearest wall, within
//   JoinDistance(before). Walls that cross are cut. A wall that this leaves without length is left out, with a warning.
// * A new door that lies on a wall makes a gap in it. One that ends at no wall is kept, with a warning.
// * Rooms are found anew where walls or doors differ. Each has the name of the room of `drawn` whose inside it has,
//   the largest of several.
// * The scale of `before` stays unless `drawn` has one. Shafts are those of `drawn`.
//
// INVALID_ARGUMENT, RESOURCE_EXHAUSTED: as CheckPlan.
absl::StatusOr<EditedPlan> ApplyEdits(const PlanGraph& before, const PlanGraph& drawn);

}  // namespace enfilade::prior
