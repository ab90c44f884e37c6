// SPDX-License-Identifier: Apache-2.0
#include "core/prior/correction/displacement_field.h"

#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

namespace enfilade::prior {
namespace {

constexpr std::size_t kMostForModel = 300;

// Matern's covariance of smoothness 5/2.
double Smooth(double distance, double range) {
  const double d = std::sqrt(5.0) * distance / range;
  return (1 + d + d * d / 3) * std::exp(-d);
}

// How the distortion of the whole plan moves a point: shift x, shift y, turn, growth, stretch, shear, each with its
// standard deviation.
Eigen::Matrix<double, 2, 6> DriftAt(const FieldModel& model, const Eigen::Vector2d& r) {
  Eigen::Matrix<double, 2, 6> drift;
  drift.col(0) = model.shift * Eigen::Vector2d::UnitX();
  drift.col(1) = model.shift * Eigen::Vector2d::UnitY();
  drift.col(2) = model.turn * Eigen::Vector2d(-r.y(), r.x());
  drift.col(3) = model.turn * r;
  drift.col(4) = model.distortion * Eigen::Vector2d(r.x(), -r.y());
  drift.col(5) = model.distortion * Eigen::Vector2d(r.y(), r.x());
  return drift;
}

// What two places share of their corners' own displacements.
double SharedCorners(const PlanPlace& a, const PlanPlace& b) {
  double shared = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t j = 0; j < 2; ++j) {
      if (a.corners[i] >= 0 && a.corners[i] == b.corners[j]) shared += a.shares[i] * b.shares[j];
    }
  }
  return shared;
}

// Of each component of the displacements at two places, but for the drift.
double Own(const FieldModel& model, const PlanPlace& a, const PlanPlace& b) {
  return model.bend * model.bend * Smooth((a.point - b.point).norm(), model.range) +
         model.corner * model.corner * SharedCorners(a, b);
}

}  // namespace

DisplacementField::DisplacementField(const FieldModel& model, std::vector<PlanOffset> offsets,
                                     const std::vector<double>& weights)
    : model_(model), offsets_(std::move(offsets)) {
  const auto size = static_cast<Eigen::Index>(offsets_.size());
  for (const PlanOffset& one : offsets_) centre_ += one.place.point / static_cast<double>(size);
  Eigen::MatrixXd matrix(size, size);
  Eigen::VectorXd values(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const PlanOffset& a = offsets_[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j <= i; ++j) matrix(i, j) = Covariance(a, offsets_[static_cast<std::size_t>(j)]);
    const double weight = weights.empty() ? 1.0 : weights[static_cast<std::size_t>(i)];
    matrix(i, i) += a.sigma * a.sigma / weight;
    values(i) = a.offset;
  }
  factor_.compute(matrix);  // reads the lower triangle only
  solved_ = factor_.solve(values);
  double log_determinant = 0;
  for (Eigen::Index i = 0; i < size; ++i) log_determinant += 2 * std::log(factor_.matrixLLT()(i, i));
  log_likelihood_ = -0.5 * (values.dot(solved_) + log_determinant + static_cast<double>(size) * std::log(2 * M_PI));
}

double DisplacementField::Covariance(const PlanOffset& a, const PlanOffset& b) const {
  const Eigen::Matrix<double, 1, 6> drift_a = a.normal.transpose() * DriftAt(model_, a.place.point - centre_);
  const Eigen::Matrix<double, 1, 6> drift_b = b.normal.transpose() * DriftAt(model_, b.place.point - centre_);
  return drift_a.dot(drift_b) + a.normal.dot(b.normal) * Own(model_, a.place, b.place);
}

Eigen::MatrixX2d DisplacementField::CrossCovariance(const PlanPlace& place) const {
  const Eigen::Matrix<double, 2, 6> drift = DriftAt(model_, place.point - centre_);
  Eigen::MatrixX2d cross(offsets_.size(), 2);
  for (Eigen::Index i = 0; i < cross.rows(); ++i) {
    const PlanOffset& one = offsets_[static_cast<std::size_t>(i)];
    const Eigen::Vector2d of_drift = drift * (DriftAt(model_, one.place.point - centre_).transpose() * one.normal);
    cross.row(i) = (of_drift + Own(model_, place, one.place) * one.normal).transpose();
  }
  return cross;
}

Eigen::Vector2d DisplacementField::MeanAt(const PlanPlace& place) const {
  return CrossCovariance(place).transpose() * solved_;
}

Displacement DisplacementField::At(const PlanPlace& place) const {
  const Eigen::MatrixX2d cross = CrossCovariance(place);
  const Eigen::Matrix<double, 2, 6> drift = DriftAt(model_, place.point - centre_);
  Displacement displacement;
  displacement.mean = cross.transpose() * solved_;
  const Eigen::MatrixX2d half = factor_.matrixL().solve(cross);
  displacement.covariance =
      drift * drift.transpose() + Own(model_, place, place) * Eigen::Matrix2d::Identity() - half.transpose() * half;
  return displacement;
}

std::vector<double> DisplacementField::SurpriseOf(const std::vector<int>& groups) const {
  const std::vector<std::vector<Eigen::Index>> members = MembersOf(groups);
  // With the inverse covariance P, what the others predict of group g is wrong by P_gg^-1 (P y)_g, with the covariance
  // P_gg^-1 (Rasmussen and Williams, equations 5.10 to 5.12, for more than one).
  const Eigen::MatrixXd inverse = factor_.solve(Eigen::MatrixXd::Identity(solved_.size(), solved_.size()));
  std::vector<double> surprise(members.size(), 0.0);
  for (std::size_t group = 0; group < members.size(); ++group) {
    if (members[group].empty()) continue;
    const Eigen::MatrixXd own = inverse(members[group], members[group]);
    const Eigen::VectorXd of_group = solved_(members[group]);
    surprise[group] = of_group.dot(own.llt().solve(of_group)) / static_cast<double>(members[group].size());
  }
  return surprise;
}

double DisplacementField::LogOddsToChance(double log_chance) const {
  // What the others predict of offset i follows from the inverse covariance (Rasmussen and Williams, equations 5.10 to
  // 5.12). It is kept for those that are left; of the others, rows and columns become zero.
  const Eigen::Index size = solved_.size();
  Eigen::MatrixXd inverse = factor_.solve(Eigen::MatrixXd::Identity(size, size));
  Eigen::VectorXd solved = solved_;
  std::vector<bool> is_left(static_cast<std::size_t>(size), true);
  double log_odds = log_likelihood_ - log_chance * static_cast<double>(size);
  for (;;) {
    Eigen::Index worst = -1;
    double lowest = 0;
    for (Eigen::Index i = 0; i < size; ++i) {
      if (!is_left[static_cast<std::size_t>(i)]) continue;
      const double precision = inverse(i, i);
      const double predicted = 0.5 * (std::log(precision / (2 * M_PI)) - solved(i) * solved(i) / precision);
      if (predicted - log_chance >= lowest) continue;
      lowest = predicted - log_chance;
      worst = i;
    }
    if (worst < 0) return log_odds;
    log_odds -= lowest;
    is_left[static_cast<std::size_t>(worst)] = false;
    const Eigen::VectorXd column = inverse.col(worst) / inverse(worst, worst);
    solved -= solved(worst) * column;
    inverse -= column * inverse.row(worst).eval();
  }
}

FieldModel LikeliestModel(const std::vector<PlanOffset>& offsets, const std::vector<double>& weights) {
  const std::size_t stride = offsets.size() / kMostForModel + 1;
  std::vector<PlanOffset> some;
  std::vector<double> of_some;
  for (std::size_t i = 0; i < offsets.size(); i += stride) {
    some.push_back(offsets[i]);
    of_some.push_back(weights.empty() ? 1.0 : weights[i]);
  }
  FieldModel best;
  double highest = -std::numeric_limits<double>::infinity();
  for (const double distortion : {0.003, 0.01, 0.03}) {
    for (const double bend : {0.03, 0.15, 0.4}) {
      for (const double range : {5.0, 10.0, 25.0}) {
        for (const double corner : {0.02, 0.06, 0.15}) {
          FieldModel model;
          model.distortion = distortion;
          model.bend = bend;
          model.range = range;
          model.corner = corner;
          const double likelihood = DisplacementField(model, some, of_some).log_likelihood();
          if (!(likelihood > highest)) continue;
          highest = likelihood;
          best = model;
        }
      }
    }
  }
  return best;
}

}  // namespace enfilade::prior
