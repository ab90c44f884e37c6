// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>

#include "absl/status/status.h"

namespace enfilade::prior {

// What of a robot's sight is compared with a plan.
enum class PlanSight : std::uint8_t {
  kField,  // the ends of beams with the distance to the plan's walls
  kNdt,    // the normal distributions of what the robot has seen lately with the plan's walls
};
std::string_view NameOf(PlanSight sight);
std::optional<PlanSight> PlanSightFrom(std::string_view name);

// How the likelihoods of a scan's beams become that of the scan.
enum class BeamSum : std::uint8_t {
  kTempered,  // their geometric mean, to the power of the effective beams
  kCubes,     // 1 + the sum of their cubes, as in AMCL
};

// Asked now and then during a search. An error ends the search and becomes its result: CANCELLED, DEADLINE_EXCEEDED.
using KeepGoing = std::function<absl::Status()>;

// How a robot is located in a plan that is not corrected. Standard deviations unless said otherwise.
struct PlanLocalizerOptions {
  std::uint64_t seed = 1;
  PlanSight sight = PlanSight::kField;  // until a place is certain: kField
  bool free_scale = true;               // false: the scale that the start says, the same along both axes

  // --- What robots see.
  int beams = 60;              // of a scan, at most
  double max_range = 10.0;     // m: a plan that is drawn wrong is right nearby only
  double cell = 0.5;           // m, the side of a cell of the normal distributions
  double recent = 4.0;         // m of the drive that they are made of, and that a global start looks at
  double point_spacing = 0.1;  // m, between points of a scan

  // --- How likely a beam is (Thrun, Burgard, Fox, "Probabilistic Robotics", 2005, section 6.4):
  //   z_hit exp(-d^2 / (2 (sigma_hit^2 + sigma_plan^2 + (stretch_per_metre range)^2))) + z_rand.
  // Furniture in the plan's free ground, and walls that were built since, are the uniform part.
  double z_hit = 0.75;
  double z_rand = 0.25;
  double sigma_hit = 0.10;          // m
  double sigma_plan = 0.15;         // m, of a wall in the plan
  double stretch_per_metre = 0.02;  // by which a plan is wrong within sight
  BeamSum sum = BeamSum::kTempered;
  double effective_beams = 12;  // neighbouring beams, and what is seen from neighbouring places, err together

  // --- How the robot moves, by SLAM, and by how much the plan is too long or too short on the way.
  double update_distance = 0.5;     // m, or
  double update_angle = 0.35;       // rad: so far the robot moves between two comparisons
  double translation_noise = 0.06;  // m per sqrt(m)
  double yaw_noise = 0.02;          // rad per sqrt(m)
  double turn_noise = 0.03;         // rad per sqrt(rad)
  double scale_noise = 0.012;       // of the logarithms of scale and stretch, per sqrt(m)

  // --- Where it may be at the start.
  double click_sigma = 0.3;      // m, in each axis, of the points that people show
  double scale_spread = 0.223;   // of the logarithm of each axis' scale, either way: 0.8 to 1.25
  double stretch_sigma = 0.09;   // where pairs tell the scale: of the logarithm of the stretch
  double mirrored_share = 0.2;   // the chance that a plan is mirrored
  double global_distance = 2.0;  // m that the robot drives before it is looked for everywhere
  double global_density = 1500;  // places that are tried per square metre of the plan ...
  int most_global = 4'000'000;   // ... but at most
  double global_sigma = 0.45;    // m, of walls when they are tried
  double global_beams = 6;       // effective ones, each time
  double global_aligned = 0.75;  // share of the places that are turned so that walls have the directions of the plan's
  // After a start anywhere the robot is looked for everywhere again and again: whoever is not among the particles would
  // never be found. Nothing is certain before the second time.
  double survey_distance = 4.0;  // m between two times ...
  double survey_until = 30.0;    // ... up to so many
  double survey_share = 0.1;     // of all weight, of what is found

  // --- Particles (D. Fox, "Adapting the sample size in particle filters through KLD-sampling", 2003).
  int fewest_particles = 500;
  int most_particles = 5000;
  int most_unsure = 20000;  // until a mode is confident
  double kld_error = 0.05;
  double kld_quantile = 2.3263;  // of the normal distribution at 1 - delta = 0.99
  double bin = 0.5;              // plan metres
  double bin_angle = 0.2618;     // rad (15 degrees)
  // Recovery (Thrun, Burgard, Fox, section 8.3.5): the share max(0, 1 - fast / slow) of new particles comes from
  // wherever the last scans fit.
  double alpha_slow = 0.001;
  double alpha_fast = 0.1;
  double most_recovered = 0.05;     // share of new particles
  double recovery_distance = 10.0;  // m since a mode was confident: until then, it is not given up for another place

  // --- Modes.
  double least_density = 0.02;  // of the heaviest bin: a bin that has less separates modes
  double confident_mass = 0.95;
  double confident_sigma = 0.6;     // m, in the least certain direction
  double confident_yaw = 0.2;       // rad
  double confident_match = 0.5;     // share of hits within two standard deviations of a wall, lately
  double confident_distance = 3.0;  // m for which all of that must have held
  double lasting_mass = 0.8;        // that a mode needs to stay confident
  // Unless two pairs or more say where the robot started, no mode is confident before its rivals are ruled out.
  bool compare_rivals = true;
  // Added to a mode's covariance: where a place of the building is in a plan is no more certain than this.
  double sigma_floor = 0.02;  // m
  double yaw_floor = 0.005;   // rad
};

// Nav2's AMCL with its default parameters, and without a scale: likelihood field, z_hit 0.5, z_rand 0.5 over 100 m,
// sigma_hit 0.2 m, 60 beams, 500 to 2000 particles (but as many as here until a mode is confident), no recovery
// (nav2_amcl, documentation of its parameters).
PlanLocalizerOptions WithNav2Measurement(PlanLocalizerOptions options);

}  // namespace enfilade::prior
