// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/prior/alignment/aligner.h"
#include "core/prior/alignment/control_pairs.h"
#include "core/prior/alignment/judged_places.h"
#include "core/prior/alignment/map_evidence.h"
#include "core/prior/alignment/plan_transform.h"
#include "core/prior/localization/localizer_options.h"
#include "core/prior/localization/particles.h"
#include "core/prior/localization/plan_field.h"
#include "core/prior/localization/plan_look.h"
#include "core/prior/localization/plan_state.h"

namespace enfilade::prior {

// Where the plan lies in the robot's own map if the robot, which is at `T_map_robot` there, is at `state` in the plan.
PlanTransform PlaceOf(const PlanField& field, const PlanState& state, const Pose2& T_map_robot);
// The reverse. A shear of the place is left out.
PlanState StateAt(const PlanField& field, const PlanTransform& T_map_sheet, const Pose2& T_map_robot);

// Which of the places where a robot may be is right.
struct PlaceVerdict {
  // The place that explains what was seen so much better than all others that they are ruled out; unset: none does.
  std::optional<PlanTransform> proven;
  // The mode that was asked for is ruled out: these are left, the likeliest first.
  std::vector<PlanTransform> likelier;
};

// Tells places apart that look alike while the plan is not corrected, as the two ends of a building that is nearly the
// same when it is turned by half. What the robot has seen becomes a map; the plan is placed in it where the robot may
// be, and where else it fits; it is corrected at each of these places, and the evidence is compared, as when a plan is
// aligned with a whole map (alignment/align.h).
class RivalPlaces {
 public:
  // `pairs`: empty, or the one that people have shown: no place is more than 3 m from there. `field` outlives it.
  RivalPlaces(const PlanField& field, const std::vector<ControlPair>& pairs, const PlanLocalizerOptions& options,
              const KeepGoing& keep_going);

  // In order of time; `travelled`: m. Looks from more than 40 m before the last one are forgotten.
  void Add(const PlanLook& look, double travelled);
  // Places found by a search of the whole plan, instead of those before: rivals, too.
  void Remember(const std::vector<PlanMode>& found, const Pose2& T_map_robot);
  // Whether the first of these modes is right. `everywhere`: before a place is proven, rivals are looked for in the
  // whole plan, at all scales and stretched. Nothing is proven once `keep_going` has failed.
  PlaceVerdict Compare(const std::vector<PlanMode>& modes, const Pose2& T_map_robot, bool everywhere);

 private:
  struct Seen {
    double travelled;
    PlanLook look;
  };

  MapEvidence Evidence() const;
  std::vector<PlanTransform> KnownRivals(const std::vector<PlanMode>& modes, const Pose2& T_map_robot) const;
  std::vector<JudgedPlace> Judged(const Candidate& own, std::vector<Candidate> rivals, const Aligner& aligner,
                                  const MapEvidence& evidence) const;
  bool IsShown(const PlanTransform& place) const;

  const PlanField& field_;
  std::vector<ControlPair> pairs_;
  AlignOptions aligning_;
  std::deque<Seen> seen_;
  std::vector<PlanTransform> found_;   // by the last search
  std::vector<PlanTransform> judged_;  // the likeliest, the last time
};

}  // namespace enfilade::prior
