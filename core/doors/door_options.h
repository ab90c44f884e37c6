// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace enfilade::doors {

// The presets original-code and original-yaml have the published parameters of map_manager: its C++ defaults and its
// params.yaml, which differ. Parameter names in brackets are map_manager's. The preset `default` uses the group `gap`
// instead of `derivative`. docs/doors.md describes the criteria.

// How door posts are found ahead and behind.
enum class DoorMethod {
  kGap = 0,         // narrow places in a local map of the last scans, crossed by the robot's path
  kDerivative = 1,  // jumps of the range along one scan, as in map_manager
};

// Criteria "door ahead" and "door behind" by the derivative D = (r[j + w] - r[j - w]) / 2 along one scan.
struct DerivativeOptions {
  double front_sector = 50.0;  // deg: ahead is |bearing| up to this
  double back_sector = 130.0;  // deg: behind is |bearing| from this
  double half_window = 5.0;    // deg, w above (10 beams of 0.5 deg)
  double post_offset = 2.5;    // deg before beam j lies the beam that must be on a post (5 beams)
  double threshold = 0.8;      // m, of |D| at a post (deriv_door_thr: yaml 0.8, code 1.0)
  double post_min = 1.0;       // m, a post is nearer than post_max and farther than this
  double post_max = 2.0;       // m
  double opening_min = 20.0;   // deg between the two posts
  double opening_max = 60.0;   // deg
  int hits = 3;                // of the criterion, to count
  double front_window = 3.0;   // s from the first hit ahead, in which all must come
  double front_spacing = 0.5;  // s at least between hits ahead
  double back_spacing = 0.15;  // s at least between hits behind
  double min_distance = 1.5;   // m from the candidate's pose to where the door is behind
  double max_distance = 5.0;   // m
  double max_heading = 30.0;   // deg that the heading may change in between
  // Scanners that do not look back: the door ahead, seen again after the robot has turned round, stands for the door
  // behind. false: the criterion is dropped.
  bool turned_stands_for_behind = true;
};

// Criterion "environment": a box around the low-pass filtered scan changes (derivative method), or what was seen before
// the door is out of sight behind it (gap method).
struct EnvironmentOptions {
  int filter_half_width = 60;   // beams (low_pass_filter_size_env: yaml 60, code 50)
  double change = 2.0;          // m, of half the change of a side (deriv_range_thr)
  int sides = 2;                // that must change
  double interval = 3.0;        // s between two boxes
  double outdoor_guard = 10.0;  // m: outdoors a side counts only if it is or was nearer
  bool outdoor = false;         // the guard is on
  double settle = 1.0;          // m before and behind the door: the scans that the gap method compares
  double hidden = 0.40;         // share of the ground out of sight, at least
  double same = 0.15;           // hidden share below which the environment speaks against a door
  double radius = 4.0;          // m around the door: the ground that is compared
  double min_compared = 0.3;    // share of it in the other scan's field of view, or the criterion is dropped
};

// Criteria "door ahead" and "door behind" by narrow places.
struct GapOptions {
  double cell = 0.05;        // m, of the local map
  double reach = 5.0;        // m, of beams put into it
  double min_width = 0.6;    // m, between the posts
  double max_width = 2.1;    // m
  double widening = 0.25;    // m: before and behind, within `shoulder`, the way is wider by this
  double shoulder = 1.1;     // m
  double max_depth = 0.75;   // m along the way, of the narrow place
  double repeated = 0.7;     // m within 2.5 m of the way that are as narrow: it is the way's usual width
  double min_angle = 28.0;   // deg between the line from post to post and the way
  double look_ahead = 2.2;   // m
  int hits = 3;              // scans that see the same place ahead
  double sparse = 0.2;       // m from the scan before: from here on a scan counts twice
  double same_place = 0.40;  // m, between two sightings
  double lag = 1.0;          // m driven beyond the door before the decision
  double detour = 2.0;       // m: a way round within this radius speaks against a door
  double spacing = 1.0;      // m to be driven between two passages
  // Behind the robot the walls are known and judged, so these limits on the way's widths are weaker:
  double behind_depth = 1.2;     // m, as max_depth
  double behind_repeated = 1.6;  // m, as repeated
  double behind_widening = 0.1;  // m, as widening
  double wall_reach = 2.2;       // m beyond each post in which the wall is looked for
  double wall_beside = 0.8;      // m of uninterrupted wall in line with the posts, both sides together, at least
  double wall = 1.9;             // m, the same with wall that continues behind a pane of glass
  double wall_across = 0.3;      // m, instead of both, of a wall across a corridor from one side to the other
  double long_wall = 2.0;        // m of wall that outweigh a way round or ground that stays in sight
  double slender = 5.0;   // ratio of a wall's length to its depth along the way at the posts; furniture's is less
  double parallel = 0.5;  // m of walls beside the way at both posts: a corridor, not a door
};

struct DoorOptions {
  DoorMethod method = DoorMethod::kGap;
  DerivativeOptions derivative;
  GapOptions gap;
  EnvironmentOptions environment;
  int criteria = 2;                // of the three that must hold
  double time_limit = 15.0;        // s from the first hit (time_limit_door_detection)
  double candidate_spacing = 2.0;  // m at least between two candidates

  // INVALID_ARGUMENT naming the option that is out of range.
  absl::Status Validate() const;
};

// "default", "original-yaml" or "original-code". INVALID_ARGUMENT naming these.
absl::StatusOr<DoorOptions> DoorPreset(std::string_view name);
std::vector<std::string> DoorPresetNames();

template <typename Options, typename Visit>
void VisitDerivativeOptions(Options& o, Visit& visit) {
  visit("derivative.front_sector", o.front_sector);
  visit("derivative.back_sector", o.back_sector);
  visit("derivative.half_window", o.half_window);
  visit("derivative.post_offset", o.post_offset);
  visit("derivative.threshold", o.threshold);
  visit("derivative.post_min", o.post_min);
  visit("derivative.post_max", o.post_max);
  visit("derivative.opening_min", o.opening_min);
  visit("derivative.opening_max", o.opening_max);
  visit("derivative.hits", o.hits);
  visit("derivative.front_window", o.front_window);
  visit("derivative.front_spacing", o.front_spacing);
  visit("derivative.back_spacing", o.back_spacing);
  visit("derivative.min_distance", o.min_distance);
  visit("derivative.max_distance", o.max_distance);
  visit("derivative.max_heading", o.max_heading);
  visit("derivative.turned_stands_for_behind", o.turned_stands_for_behind);
}

template <typename Options, typename Visit>
void VisitEnvironmentOptions(Options& o, Visit& visit) {
  visit("environment.filter_half_width", o.filter_half_width);
  visit("environment.change", o.change);
  visit("environment.sides", o.sides);
  visit("environment.interval", o.interval);
  visit("environment.outdoor_guard", o.outdoor_guard);
  visit("environment.outdoor", o.outdoor);
  visit("environment.settle", o.settle);
  visit("environment.hidden", o.hidden);
  visit("environment.same", o.same);
  visit("environment.radius", o.radius);
  visit("environment.min_compared", o.min_compared);
}

template <typename Options, typename Visit>
void VisitGapOptions(Options& o, Visit& visit) {
  visit("gap.cell", o.cell);
  visit("gap.reach", o.reach);
  visit("gap.min_width", o.min_width);
  visit("gap.max_width", o.max_width);
  visit("gap.widening", o.widening);
  visit("gap.shoulder", o.shoulder);
  visit("gap.max_depth", o.max_depth);
  visit("gap.repeated", o.repeated);
  visit("gap.min_angle", o.min_angle);
  visit("gap.look_ahead", o.look_ahead);
  visit("gap.hits", o.hits);
  visit("gap.sparse", o.sparse);
  visit("gap.same_place", o.same_place);
  visit("gap.lag", o.lag);
  visit("gap.detour", o.detour);
  visit("gap.spacing", o.spacing);
  visit("gap.behind_depth", o.behind_depth);
  visit("gap.behind_repeated", o.behind_repeated);
  visit("gap.behind_widening", o.behind_widening);
  visit("gap.wall_reach", o.wall_reach);
  visit("gap.wall_beside", o.wall_beside);
  visit("gap.wall", o.wall);
  visit("gap.wall_across", o.wall_across);
  visit("gap.long_wall", o.long_wall);
  visit("gap.slender", o.slender);
  visit("gap.parallel", o.parallel);
}

// Calls visit("group.name", value) for every option; `Options` is DoorOptions, const or not.
template <typename Options, typename Visit>
void VisitDoorOptions(Options& o, Visit visit) {
  visit("criteria", o.criteria);
  visit("time_limit", o.time_limit);
  visit("candidate_spacing", o.candidate_spacing);
  VisitDerivativeOptions(o.derivative, visit);
  VisitEnvironmentOptions(o.environment, visit);
  VisitGapOptions(o.gap, visit);
}

// Options from YAML by the names above in nested maps, on top of `base`; `preset: NAME` in the file replaces the base.
// INVALID_ARGUMENT naming key and line: a key that does not exist, a value of another type, what Validate refuses.
absl::StatusOr<DoorOptions> ParseDoorOptions(std::string_view yaml, const DoorOptions& base);
// All options as YAML that ParseDoorOptions reads back to the same values.
std::string FormatDoorOptions(const DoorOptions& options);

}  // namespace enfilade::doors
