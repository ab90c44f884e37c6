// SPDX-License-Identifier: Apache-2.0
#include "core/prior/localization/particles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "core/base/disjoint_sets.h"

namespace enfilade::prior {
namespace {

using BinKey = std::array<int, 4>;  // x, y, yaw, mirrored

BinKey BinOf(const PlanState& state, const PlanLocalizerOptions& options) {
  return {static_cast<int>(std::floor(state.x / options.bin)), static_cast<int>(std::floor(state.y / options.bin)),
          static_cast<int>(std::floor((WrapAngle(state.yaw) + M_PI) / options.bin_angle)), state.mirrored ? 1 : 0};
}

struct ModeSums {
  double weight = 0;
  double x = 0, y = 0, cosine = 0, sine = 0, scale = 0, stretch = 0;
  bool mirrored = false;

  PlanState Mean() const {
    return {x / weight, y / weight, std::atan2(sine, cosine), scale / weight, stretch / weight, mirrored};
  }
};

}  // namespace

void Normalise(std::vector<PlanParticle>& particles) {
  double sum = 0;
  for (const PlanParticle& particle : particles) sum += particle.weight;
  for (PlanParticle& particle : particles) {
    particle.weight = sum > 0 ? particle.weight / sum : 1.0 / static_cast<double>(particles.size());
  }
}

double EffectiveCount(const std::vector<PlanParticle>& particles) {
  double squares = 0;
  for (const PlanParticle& particle : particles) squares += particle.weight * particle.weight;
  return squares > 0 ? 1 / squares : 0;
}

std::vector<std::size_t> LowVarianceSample(const std::vector<double>& weights, std::size_t count, double random) {
  double sum = 0;
  for (const double weight : weights) sum += weight;
  std::vector<std::size_t> drawn;
  drawn.reserve(count);
  double passed = 0;
  std::size_t i = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const double target = (static_cast<double>(k) + random) / static_cast<double>(count) * sum;
    while (i + 1 < weights.size() && passed + weights[i] <= target) passed += weights[i++];
    drawn.push_back(i);
  }
  return drawn;
}

std::size_t KldCount(std::size_t bins, const PlanLocalizerOptions& options) {
  if (bins < 2) return 1;
  const auto free = static_cast<double>(bins - 1);
  const double part = 2 / (9 * free);
  const double root = 1 - part + std::sqrt(part) * options.kld_quantile;
  return static_cast<std::size_t>(std::ceil(free / (2 * options.kld_error) * root * root * root));
}

std::vector<PlanParticle> Resampled(const std::vector<PlanParticle>& particles, std::size_t most, double random,
                                    const PlanLocalizerOptions& options) {
  std::vector<double> weights;
  for (const PlanParticle& particle : particles) weights.push_back(particle.weight);
  std::set<BinKey> bins;
  for (const std::size_t i : LowVarianceSample(weights, most, random)) bins.insert(BinOf(particles[i].state, options));
  const std::size_t count =
      std::clamp(KldCount(bins.size(), options), static_cast<std::size_t>(options.fewest_particles), most);
  std::vector<PlanParticle> resampled;
  for (const std::size_t i : LowVarianceSample(weights, count, random)) {
    resampled.push_back({particles[i].state, 1.0 / static_cast<double>(count)});
  }
  return resampled;
}

namespace {

// Of each particle its mode, or -1.
std::vector<int> ModeOfEach(const std::vector<PlanParticle>& particles, const PlanLocalizerOptions& options) {
  std::map<BinKey, double> filled;
  for (const PlanParticle& particle : particles) filled[BinOf(particle.state, options)] += particle.weight;
  double heaviest = 0;
  for (const auto& [key, weight] : filled) heaviest = std::max(heaviest, weight);
  std::map<BinKey, std::size_t> number;
  for (const auto& [key, weight] : filled) {
    if (weight >= options.least_density * heaviest) number.emplace(key, number.size());
  }
  const int turns = static_cast<int>(std::ceil(2 * M_PI / options.bin_angle));
  DisjointSets sets(number.size());
  for (const auto& [key, i] : number) {
    for (int neighbour = 0; neighbour < 27; ++neighbour) {
      BinKey beside = key;
      beside[0] += neighbour % 3 - 1;
      beside[1] += neighbour / 3 % 3 - 1;
      beside[2] = (beside[2] + neighbour / 9 - 1 + turns) % turns;
      const auto found = number.find(beside);
      if (found != number.end()) sets.Join(i, found->second);
    }
  }
  std::vector<int> modes;
  for (const PlanParticle& particle : particles) {
    const auto found = number.find(BinOf(particle.state, options));
    modes.push_back(found == number.end() ? -1 : static_cast<int>(sets.Find(found->second)));
  }
  return modes;
}

}  // namespace

std::vector<PlanMode> ModesOf(const std::vector<PlanParticle>& particles, double axis,
                              const PlanLocalizerOptions& options) {
  const std::vector<int> mode_of = ModeOfEach(particles, options);
  std::map<int, ModeSums> sums;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    if (mode_of[i] < 0) continue;
    const auto& [state, weight] = particles[i];
    ModeSums& sum = sums[mode_of[i]];
    sum.weight += weight;
    sum.x += weight * state.x;
    sum.y += weight * state.y;
    sum.cosine += weight * std::cos(state.yaw);
    sum.sine += weight * std::sin(state.yaw);
    sum.scale += weight * state.log_scale;
    sum.stretch += weight * state.log_stretch;
    sum.mirrored = state.mirrored;
  }
  std::map<int, PlanMode> modes;
  for (const auto& [key, sum] : sums) {
    if (sum.weight > 0) modes[key] = {.mass = sum.weight, .mean = sum.Mean()};
  }
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const auto found = modes.find(mode_of[i]);
    if (found == modes.end()) continue;
    PlanMode& mode = found->second;
    const auto& [state, weight] = particles[i];
    const Eigen::Vector2d off = MetresOf(mode.mean, axis) * (state.translation() - mode.mean.translation());
    const Eigen::Vector4d error(off.x(), off.y(), WrapAngle(state.yaw - mode.mean.yaw),
                                state.log_scale - mode.mean.log_scale);
    const double stretch = state.log_stretch - mode.mean.log_stretch;
    mode.covariance += weight / mode.mass * error * error.transpose();
    mode.stretch_sigma += weight / mode.mass * stretch * stretch;
  }
  std::vector<PlanMode> ranked;
  for (auto& [key, mode] : modes) {
    mode.stretch_sigma = std::sqrt(mode.stretch_sigma);
    mode.covariance.diagonal() +=
        Eigen::Vector4d(options.sigma_floor * options.sigma_floor, options.sigma_floor * options.sigma_floor,
                        options.yaw_floor * options.yaw_floor, 0);
    ranked.push_back(mode);
  }
  std::stable_sort(ranked.begin(), ranked.end(), [](const PlanMode& a, const PlanMode& b) { return a.mass > b.mass; });
  return ranked;
}

}  // namespace enfilade::prior
