// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/prior/localization/localizer_options.h"
#include "core/prior/localization/ndt_map.h"
#include "core/prior/localization/plan_field.h"
#include "core/prior/localization/plan_state.h"

namespace enfilade::prior {

// What a robot sees, ready to be compared with a plan at many places: single hits, or normal distributions. In the
// robot's frame, m.
class PlanLikelihood {
 public:
  // The ends of beams, of which the options say how many count.
  static PlanLikelihood OfHits(const std::vector<Eigen::Vector2d>& hits, const PlanLocalizerOptions& options);
  // The nearest `options.beams` cells.
  static PlanLikelihood OfCells(const std::vector<NdtCell>& cells, const PlanLocalizerOptions& options);

  bool empty() const { return terms_.empty(); }
  // The logarithm, tempered; 0 if nothing was seen. With normal distributions the distance d of a cell's mean is that
  // across the nearest wall with the normal n, and its variance n' C n is added to the plan's; likelihoods are
  // densities across the wall, by that of a point (after Magnusson 2009, section 6.3, with the plan's walls as
  // distributions that are long and thin).
  double LogAt(const PlanField& field, const PlanState& state) const;
  // The share of what was seen that lies within two standard deviations of a wall.
  double MatchedAt(const PlanField& field, const PlanState& state) const;

 private:
  struct Term {
    Eigen::Vector2f point;
    float variance;              // m^2, of sensor and plan
    Eigen::Matrix2f covariance;  // m^2
  };

  PlanLikelihood(const PlanLocalizerOptions& options, bool spread) : options_(options), spread_(spread) {}
  void Add(const Eigen::Vector2d& point, const Eigen::Matrix2d& covariance);
  // Calls act(squared distance, variance), both m^2, for each term.
  template <typename Act>
  void ForEach(const PlanField& field, const PlanState& state, const Act& act) const;

  PlanLocalizerOptions options_;
  bool spread_;  // the terms have covariances
  std::vector<Term> terms_;
};

}  // namespace enfilade::prior
