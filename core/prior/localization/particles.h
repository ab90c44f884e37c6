// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/prior/localization/localizer_options.h"
#include "core/prior/localization/plan_state.h"

namespace enfilade::prior {

struct PlanParticle {
  PlanState state;
  double weight = 0;  // the sum of all is 1
};

// Divides the weights by their sum; all become equal if it is 0.
void Normalise(std::vector<PlanParticle>& particles);

// 1 / the sum of squared weights.
double EffectiveCount(const std::vector<PlanParticle>& particles);

// `count` indices, each about as often as its weight says, by one random number in [0, 1) (low-variance sampling:
// Thrun, Burgard, Fox, "Probabilistic Robotics", 2005, table 4.4). `weights`: their sum is not 0.
std::vector<std::size_t> LowVarianceSample(const std::vector<double>& weights, std::size_t count, double random);

// How many particles represent what fills `bins` bins with an error of at most options.kld_error (Fox 2003, eq. 7).
std::size_t KldCount(std::size_t bins, const PlanLocalizerOptions& options);

// Resamples into as many particles, all with the same weight, as the spread of what was drawn needs, from
// options.fewest_particles to `most`.
std::vector<PlanParticle> Resampled(const std::vector<PlanParticle>& particles, std::size_t most, double random,
                                    const PlanLocalizerOptions& options);

// A cluster of particles: the bins that hang together, neighbours in place and heading.
struct PlanMode {
  double mass = 0;  // share of all particles' weight
  PlanState mean;
  // Of (x, y, yaw, log_scale): m^2, rad^2. Along the plan frame's axes, in metres. Contains the options' floors.
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  double stretch_sigma = 0;
};

// The heaviest first. What lies in thinly filled bins belongs to none.
std::vector<PlanMode> ModesOf(const std::vector<PlanParticle>& particles, double axis,
                              const PlanLocalizerOptions& options);

}  // namespace enfilade::prior
