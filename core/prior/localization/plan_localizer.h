// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/prior/alignment/control_pairs.h"
#include "core/prior/localization/localizer_options.h"
#include "core/prior/localization/particles.h"
#include "core/prior/localization/plan_field.h"
#include "core/prior/localization/plan_look.h"
#include "core/prior/localization/plan_state.h"
#include "core/prior/localization/rival_places.h"

namespace enfilade::prior {

// Where the robot may be after a look.
struct PlanPosterior {
  double travelled = 0;         // m since the first look
  std::size_t particles = 0;    // 0: a global start has not seen enough yet
  double effective = 0;         // particles, of them
  std::vector<PlanMode> modes;  // the heaviest first
  double matched = 0;           // share of what the robot has seen lately that is near walls, at the heaviest mode
  // The heaviest mode's rivals elsewhere are ruled out (RivalPlaces), or people have said where the robot started.
  bool proven = false;
  // One mode has enough mass, is narrow, explains what the robot sees, has done so for a while, and is proven.
  bool confident = false;
};

// Locates a robot in a plan that nobody has corrected: Monte Carlo localisation (D. Fox, W. Burgard, F. Dellaert, S.
// Thrun, 1999) whose particles also carry the plan's local scale (B. Behzadian, P. Agarwal, W. Burgard, G. Tipaldi,
// "Monte Carlo localization in hand-drawn maps", 2015), and by how much it is stretched along its axes, and whether it
// is mirrored. The same looks with the same options give the same, bit for bit.
class PlanLocalizer {
 public:
  // `pairs`: where the robot's own map lies in the plan, as people have shown (StartAtPairs); empty: anywhere. `field`
  // outlives it. `keep_going`: for searches of the whole plan; once it has failed, what Add gives means nothing.
  PlanLocalizer(const PlanField& field, const std::vector<ControlPair>& pairs, const PlanLocalizerOptions& options,
                KeepGoing keep_going = {});

  // In order of time.
  PlanPosterior Add(const PlanLook& look);

  // The particles near `state` are kept, those elsewhere dropped: within the 99.9 % gate of `covariance` (of x, y, yaw,
  // in metres along the plan frame's axes) and no less than options' floors. Does nothing if none is near.
  void Gate(const PlanState& state, const Eigen::Matrix3d& covariance);

  const std::vector<PlanParticle>& particles() const { return particles_; }

 private:
  struct Seen {
    double travelled;
    std::vector<Eigen::Vector2d> points;  // in the map frame
  };

  // Whether places elsewhere may be the right ones: people have not said where the robot is, and how it is turned.
  bool IsRivalled() const { return options_.compare_rivals && options_.free_scale && pairs_.size() < 2; }
  void Start(const Pose2& T_map_robot);
  void Move(const Pose2& motion);
  void Weigh(const PlanLook& look);
  void Resample();
  void Survey();
  PlanPosterior Report(const PlanLook& look);
  bool IsHeld(const PlanMode& best);
  bool IsSearched() const;
  bool IsProven(const std::vector<PlanMode>& modes, const Pose2& T_map_robot);
  bool IsAtProven(const PlanMode& mode, const Pose2& T_map_robot) const;
  void Judge(const std::vector<PlanMode>& modes, const Pose2& T_map_robot);
  void MoveTo(const std::vector<PlanTransform>& places, const Pose2& T_map_robot);
  std::vector<Eigen::Vector2d> RecentPoints(const Pose2& T_map_robot) const;

  const PlanField& field_;
  std::vector<ControlPair> pairs_;
  PlanLocalizerOptions options_;
  KeepGoing keep_going_;
  std::vector<PlanParticle> particles_;
  std::deque<Seen> seen_;
  std::optional<Pose2> T_map_last_;  // at the last look
  double travelled_ = 0;
  double since_update_ = 0;  // m
  double turned_ = 0;        // rad, since the update
  std::uint64_t step_ = 0;
  double slow_ = 0;  // means of the likelihood, for the recovery
  double fast_ = 0;
  double surveyed_ = 0;                  // m: where it was looked for everywhere
  int surveys_ = 0;                      // how often, since the start
  double matched_ = 0;                   // as in PlanPosterior
  bool sure_ = false;                    // one mode was confident at the last look
  std::optional<double> last_sure_;      // m: where one was at last
  std::optional<double> holding_since_;  // m: where a mode began to be alone and narrow
  RivalPlaces rivals_;
  std::optional<PlanTransform> proven_;  // where the plan lies in the robot's map: all other places are ruled out
  double proven_at_ = 0;                 // m: where that was found
  double next_judged_;                   // m: no sooner are rivals compared
};

}  // namespace enfilade::prior
