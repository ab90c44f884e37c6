// SPDX-License-Identifier: Apache-2.0
#include "core/prior/localization/plan_likelihood.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/slam/matching/scan_points.h"

namespace enfilade::prior {
namespace {

// exp(-u) for u in [0, kTableEnd), 0 beyond.
class ExpTable {
 public:
  ExpTable() {
    for (std::size_t i = 0; i < values_.size(); ++i) {
      values_[i] = static_cast<float>(std::exp(-(static_cast<double>(i) + 0.5) / kPerUnit));
    }
  }
  float operator()(float u) const {
    const float at = u * kPerUnit;
    return at < static_cast<float>(kSize) ? values_[static_cast<std::size_t>(at)] : 0.0F;
  }

 private:
  static constexpr float kPerUnit = 64;
  static constexpr std::size_t kSize = 1024;
  std::array<float, kSize> values_{};
};

const ExpTable& Exp() {
  static const ExpTable table;
  return table;
}

}  // namespace

void PlanLikelihood::Add(const Eigen::Vector2d& point, const Eigen::Matrix2d& covariance) {
  const double stretch = options_.stretch_per_metre * point.norm();
  const double variance =
      options_.sigma_hit * options_.sigma_hit + options_.sigma_plan * options_.sigma_plan + stretch * stretch;
  terms_.push_back({point.cast<float>(), static_cast<float>(variance), covariance.cast<float>()});
}

PlanLikelihood PlanLikelihood::OfHits(const std::vector<Eigen::Vector2d>& hits, const PlanLocalizerOptions& options) {
  PlanLikelihood likelihood(options, false);
  std::vector<Eigen::Vector2d> near;
  for (const Eigen::Vector2d& hit : hits) {
    if (hit.norm() <= options.max_range) near.push_back(hit);
  }
  near = slam::Subsampled(slam::Thinned(near, options.point_spacing), static_cast<std::size_t>(options.beams));
  for (const Eigen::Vector2d& hit : near) likelihood.Add(hit, Eigen::Matrix2d::Zero());
  return likelihood;
}

PlanLikelihood PlanLikelihood::OfCells(const std::vector<NdtCell>& cells, const PlanLocalizerOptions& options) {
  PlanLikelihood likelihood(options, true);
  std::vector<NdtCell> near;
  for (const NdtCell& cell : cells) {
    if (cell.mean.norm() <= options.max_range) near.push_back(cell);
  }
  std::stable_sort(near.begin(), near.end(),
                   [](const NdtCell& a, const NdtCell& b) { return a.mean.squaredNorm() < b.mean.squaredNorm(); });
  if (near.size() > static_cast<std::size_t>(options.beams)) near.resize(static_cast<std::size_t>(options.beams));
  for (const NdtCell& cell : near) likelihood.Add(cell.mean, cell.covariance);
  return likelihood;
}

template <typename Act>
void PlanLikelihood::ForEach(const PlanField& field, const PlanState& state, const Act& act) const {
  const Eigen::Matrix2f linear = LinearOf(state, field.axis()).cast<float>();
  const Eigen::Vector2f at = state.translation().cast<float>();
  const auto metres = static_cast<float>(std::exp(2 * state.log_scale));
  for (const Term& term : terms_) {
    const Eigen::Vector2f point = linear * term.point + at;
    if (!spread_) {
      act(field.SquaredDistanceAt(point) * metres, term.variance);
      continue;
    }
    const PlanField::Nearest nearest = field.NearestAt(point);
    const Eigen::Vector2f across = linear.transpose() * nearest.normal;
    act(nearest.squared_distance * metres, term.variance + metres * across.dot(term.covariance * across));
  }
}

double PlanLikelihood::LogAt(const PlanField& field, const PlanState& state) const {
  if (terms_.empty()) return 0;
  const ExpTable& exponential = Exp();
  const auto hit = static_cast<float>(options_.z_hit);
  const auto rand = static_cast<float>(options_.z_rand);
  if (options_.sum == BeamSum::kCubes) {
    double sum = 1;
    ForEach(field, state, [&](float squared, float variance) {
      const double likelihood = hit * exponential(squared / (2 * variance)) + rand;
      sum += likelihood * likelihood * likelihood;
    });
    return std::log(sum);
  }
  double product = 1;
  std::size_t i = 0;
  ForEach(field, state, [&](float squared, float variance) {
    const float alone = terms_[i++].variance;
    const float density = spread_ ? std::sqrt(alone / variance) : 1.0F;
    product *= hit * density * exponential(squared / (2 * variance)) + rand;
  });
  const auto count = static_cast<double>(terms_.size());
  return std::min(options_.effective_beams, count) / count * std::log(std::max(product, 1e-300));
}

double PlanLikelihood::MatchedAt(const PlanField& field, const PlanState& state) const {
  if (terms_.empty()) return 0;
  int matched = 0;
  ForEach(field, state, [&](float squared, float variance) { matched += squared <= 4 * variance; });
  return matched / static_cast<double>(terms_.size());
}

}  // namespace enfilade::prior
