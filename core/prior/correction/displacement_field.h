// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

#include "core/prior/correction/plan_displacement.h"

namespace enfilade::prior {

// How wrong plans are: standard deviations of what adds up to a displacement. A plan is placed before it is corrected,
// so little of its turn and growth is left.
struct FieldModel {
  double shift = 0.5;        // m
  double turn = 0.005;       // rad, and relative growth
  double distortion = 0.03;  // stretch of one axis against the other, and shear
  double bend = 0.3;         // m, that vary smoothly, over about `range`
  double range = 15;         // m
  double corner = 0.1;       // m, of each corner by itself
};

// The displacement of a plan as a Gaussian process that is given its normal components at some places (kriging with a
// distortion of the whole plan as drift; G. Matheron, "The intrinsic random functions and their applications", 1973; C.
// Rasmussen and C. Williams, "Gaussian Processes for Machine Learning", 2006, chapter 2). Near walls that were seen it
// follows them; far away it returns to the distortion that fits them all. Immutable.
class DisplacementField : public PlanDisplacement {
 public:
  // `weights`: of the offsets, in (0, 1]; empty: 1.
  DisplacementField(const FieldModel& model, std::vector<PlanOffset> offsets, const std::vector<double>& weights);

  Displacement At(const PlanPlace& place) const override;
  Eigen::Vector2d MeanAt(const PlanPlace& place) const override;
  std::vector<double> SurpriseOf(const std::vector<int>& groups) const override;
  // ln p(offsets): how well the model explains them (Rasmussen and Williams, equation 2.30).
  double log_likelihood() const { return log_likelihood_; }
  // By how much the model explains the offsets better than chance, which gives each the density exp(`log_chance`). An
  // offset that chance explains better than the model does by the others belongs to no wall of the plan and counts
  // nothing: they are left out one by one, the worst first.
  double LogOddsToChance(double log_chance) const;

 private:
  double Covariance(const PlanOffset& a, const PlanOffset& b) const;
  // Of the displacement at a place, along x and y, with each offset: n x 2.
  Eigen::MatrixX2d CrossCovariance(const PlanPlace& place) const;

  FieldModel model_;
  std::vector<PlanOffset> offsets_;
  Eigen::Vector2d centre_ = Eigen::Vector2d::Zero();
  Eigen::LLT<Eigen::MatrixXd> factor_;
  Eigen::VectorXd solved_;
  double log_likelihood_ = 0;
};

// The model among a fixed set that explains the offsets best (empirical Bayes; at most 300 offsets are looked at). None
// is so flexible that the plan of another building would pass.
FieldModel LikeliestModel(const std::vector<PlanOffset>& offsets, const std::vector<double>& weights);

}  // namespace enfilade::prior
