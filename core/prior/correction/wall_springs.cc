// SPDX-License-Identifier: Apache-2.0
#include "core/prior/correction/wall_springs.h"

#include <Eigen/Cholesky>
#include <cstddef>
#include <utility>

namespace enfilade::prior {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

void AddBlock(Triplets& triplets, int row, int column, const Eigen::Matrix2d& block) {
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) triplets.emplace_back(2 * row + i, 2 * column + j, block(i, j));
  }
}

}  // namespace

WallSprings::WallSprings(const SpringOptions& options, std::vector<Eigen::Vector2d> corners,
                         const std::vector<WallSpring>& walls, std::vector<PlanOffset> offsets,
                         const std::vector<double>& weights)
    : corners_(std::move(corners)), offsets_(std::move(offsets)) {
  const auto size = 2 * static_cast<Eigen::Index>(corners_.size());
  Triplets triplets;
  for (int i = 0; i < static_cast<int>(corners_.size()); ++i) {
    AddBlock(triplets, i, i, Eigen::Matrix2d::Identity() / options.loose);
  }
  for (const WallSpring& wall : walls) {
    const Eigen::Vector2d way =
        corners_[static_cast<std::size_t>(wall.to)] - corners_[static_cast<std::size_t>(wall.from)];
    const double length = way.norm();
    if (!(length > 0)) continue;
    Eigen::Matrix2d axes;
    axes << way.x(), -way.y(), way.y(), way.x();
    axes /= length;
    const Eigen::Matrix2d information =
        axes * Eigen::Vector2d(1 / (options.stretch_per_metre * length), 1 / options.across).asDiagonal() *
        axes.transpose();
    AddBlock(triplets, wall.from, wall.from, information);
    AddBlock(triplets, wall.to, wall.to, information);
    AddBlock(triplets, wall.from, wall.to, -information);
    AddBlock(triplets, wall.to, wall.from, -information);
  }
  Eigen::SparseMatrix<double> information(size, size);
  information.setFromTriplets(triplets.begin(), triplets.end());

  const auto count = static_cast<Eigen::Index>(offsets_.size());
  variances_.resize(count);
  Eigen::VectorXd values(count);
  Triplets of_offsets;
  for (Eigen::Index i = 0; i < count; ++i) {
    const PlanOffset& one = offsets_[static_cast<std::size_t>(i)];
    variances_(i) = one.sigma * one.sigma / (weights.empty() ? 1.0 : weights[static_cast<std::size_t>(i)]);
    values(i) = one.offset;
    for (std::size_t k = 0; k < 2; ++k) {
      if (one.place.corners[k] < 0) continue;
      for (int axis = 0; axis < 2; ++axis) {
        of_offsets.emplace_back(2 * one.place.corners[k] + axis, i, one.place.shares[k] * one.normal(axis));
      }
    }
  }
  jacobian_.resize(size, count);
  jacobian_.setFromTriplets(of_offsets.begin(), of_offsets.end());
  const Eigen::VectorXd inverse = variances_.cwiseInverse();
  information += jacobian_ * inverse.asDiagonal() * Eigen::SparseMatrix<double>(jacobian_.transpose());
  information_ = std::make_unique<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>>(information);
  moves_ = information_->solve(jacobian_ * inverse.cwiseProduct(values));
}

Eigen::SparseMatrix<double> WallSprings::InfluenceOn(const PlanPlace& place) const {
  Eigen::SparseMatrix<double> influence(moves_.size(), 2);
  PlanPlace on = place;
  if (on.corners[0] < 0 && on.corners[1] < 0 && !corners_.empty()) {
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < corners_.size(); ++i) {
      if ((corners_[i] - place.point).norm() < (corners_[nearest] - place.point).norm()) nearest = i;
    }
    on.corners = {static_cast<int>(nearest), -1};
    on.shares = {1, 0};
  }
  for (std::size_t k = 0; k < 2; ++k) {
    if (on.corners[k] < 0) continue;
    for (int axis = 0; axis < 2; ++axis) influence.coeffRef(2 * on.corners[k] + axis, axis) += on.shares[k];
  }
  return influence;
}

Eigen::Vector2d WallSprings::MeanAt(const PlanPlace& place) const { return InfluenceOn(place).transpose() * moves_; }

Displacement WallSprings::At(const PlanPlace& place) const {
  const Eigen::SparseMatrix<double> influence = InfluenceOn(place);
  const Eigen::MatrixXd spread = information_->solve(Eigen::MatrixXd(influence));
  return {influence.transpose() * moves_, influence.transpose() * spread};
}

std::vector<double> WallSprings::SurpriseOf(const std::vector<int>& groups) const {
  const std::vector<std::vector<Eigen::Index>> members = MembersOf(groups);
  std::vector<double> surprise(members.size(), 0.0);
  for (std::size_t group = 0; group < members.size(); ++group) {
    const auto size = static_cast<Eigen::Index>(members[group].size());
    if (size == 0) continue;
    Eigen::MatrixXd own(moves_.size(), size);
    Eigen::VectorXd residuals(size);
    Eigen::VectorXd variances(size);
    for (Eigen::Index i = 0; i < size; ++i) {
      const Eigen::Index offset = members[group][static_cast<std::size_t>(i)];
      own.col(i) = jacobian_.col(offset);
      residuals(i) = offsets_[static_cast<std::size_t>(offset)].offset - own.col(i).dot(moves_);
      variances(i) = variances_(offset);
    }
    // The residuals of a fit that has seen them, r, have the covariance R - J P J^T; what the others predict is wrong
    // by R (R - J P J^T)^-1 r, with the covariance R (R - J P J^T)^-1 R.
    const Eigen::MatrixXd fitted = own.transpose() * information_->solve(own);
    const Eigen::MatrixXd left = Eigen::MatrixXd(variances.asDiagonal()) - fitted;
    surprise[group] = residuals.dot(left.llt().solve(residuals)) / static_cast<double>(size);
  }
  return surprise;
}

}  // namespace enfilade::prior
