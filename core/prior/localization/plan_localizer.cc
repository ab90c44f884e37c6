// SPDX-License-Identifier: Apache-2.0
#include "core/prior/localization/plan_localizer.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/noise.h"
#include "core/prior/localization/ndt_map.h"
#include "core/prior/localization/plan_likelihood.h"
#include "core/prior/localization/plan_start.h"
#include "core/slam/matching/scan_points.h"

namespace enfilade::prior {
namespace {

constexpr double kLargestLog = 0.5;      // of scale and stretch
constexpr double kGateQuantile = 16.27;  // 99.9 % of chi squared with three degrees of freedom
constexpr double kMatchedGain = 0.15;    // for the mean of what was seen at the last looks
constexpr double kSurveyDensity = 400;   // places tried per square metre
constexpr std::uint64_t kSurveyRound = 1;
constexpr int kLeastSurveys = 2;
constexpr double kRecoveryDensity = 200;  // places tried per square metre

// Rivals of a mode are compared at most so often, and once more when so much more has been seen.
constexpr double kJudgedFrom = 8.0;            // m
constexpr double kJudgedEach = 4.0;            // m ...
constexpr double kJudgedShare = 0.2;           // ... and of the drive
constexpr double kProvenShare = 1.0;           // of the drive
constexpr double kProvenFor = 40.0;            // m, at most
constexpr double kSameRobot = 2.0;             // m: how far apart a place puts what another puts at one point ...
constexpr double kSameRobotPerMetre = 0.03;    // ... and by how much more per metre that is driven since
constexpr double kSameTurn = 0.4;              // rad
constexpr std::size_t kMovedParticles = 1000;  // for each place
constexpr double kMovedShare = 0.9;            // of all weight

enum class FilterDraw : std::uint64_t { kMotion = 1, kResample = 2, kRecover = 3, kMoved = 4 };

// One noise for each of the state's numbers.
PlanState Disturbed(PlanState state, const Pose2& motion, Noise noise, const PlanLocalizerOptions& options) {
  const double root = std::sqrt(motion.translation().norm());
  const double aside = options.translation_noise * root;
  const double turn = std::hypot(options.yaw_noise * root, options.turn_noise * std::sqrt(std::abs(motion.yaw)));
  state.x += aside * noise.Normal();
  state.y += aside * noise.Normal();
  state.yaw = WrapAngle(state.yaw + turn * noise.Normal());
  if (!options.free_scale) return state;
  const double scale = options.scale_noise * root;
  state.log_scale = std::clamp(state.log_scale + scale * noise.Normal(), -kLargestLog, kLargestLog);
  state.log_stretch = std::clamp(state.log_stretch + scale * noise.Normal(), -kLargestLog, kLargestLog);
  return state;
}

bool IsNarrow(const PlanMode& mode, const PlanLocalizerOptions& options) {
  const Eigen::Matrix2d place = mode.covariance.topLeftCorner<2, 2>();
  const double widest = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(place).eigenvalues().y();
  return widest <= options.confident_sigma * options.confident_sigma &&
         mode.covariance(2, 2) <= options.confident_yaw * options.confident_yaw;
}

}  // namespace

PlanLocalizer::PlanLocalizer(const PlanField& field, const std::vector<ControlPair>& pairs,
                             const PlanLocalizerOptions& options, KeepGoing keep_going)
    : field_(field),
      pairs_(pairs),
      options_(options),
      keep_going_(std::move(keep_going)),
      rivals_(field, pairs, options, keep_going_),
      next_judged_(kJudgedFrom) {}

PlanPosterior PlanLocalizer::Add(const PlanLook& look) {
  ++step_;
  const Pose2 motion = T_map_last_ ? Between(*T_map_last_, look.T_map_robot) : Pose2{};
  T_map_last_ = look.T_map_robot;
  travelled_ += motion.translation().norm();
  since_update_ += motion.translation().norm();
  turned_ += std::abs(motion.yaw);
  Seen seen{travelled_, {}};
  for (const Eigen::Vector2d& hit : slam::Thinned(look.hits, options_.point_spacing)) {
    if (hit.norm() <= options_.max_range) seen.points.push_back(look.T_map_robot * hit);
  }
  seen_.push_back(std::move(seen));
  if (IsRivalled()) rivals_.Add(look, travelled_);
  while (seen_.size() > 1 && seen_.front().travelled < travelled_ - options_.recent) seen_.pop_front();

  if (particles_.empty()) {
    Start(look.T_map_robot);
  } else {
    Move(motion);
    if (since_update_ >= options_.update_distance || turned_ >= options_.update_angle) Weigh(look);
  }
  return Report(look);
}

void PlanLocalizer::Start(const Pose2& T_map_robot) {
  const auto most = static_cast<std::size_t>(options_.most_unsure);
  if (!pairs_.empty()) {
    particles_ = StartAtPairs(field_, pairs_, T_map_robot, most, options_);
    last_sure_ = travelled_;  // people are
  } else if (travelled_ >= options_.global_distance) {
    particles_ =
        StartAnywhere(field_, RecentPoints(T_map_robot), {most, 0, options_.global_density}, options_, keep_going_);
    if (!particles_.empty()) rivals_.Remember(ModesOf(particles_, field_.axis(), options_), T_map_robot);
  }
  surveyed_ = travelled_;
  since_update_ = 0;
  turned_ = 0;
}

// In the robot's frame, thinned to one in each cell of options.point_spacing, in the order of the cells.
std::vector<Eigen::Vector2d> PlanLocalizer::RecentPoints(const Pose2& T_map_robot) const {
  std::vector<Eigen::Vector2d> points;
  const Pose2 T_robot_map = Inverse(T_map_robot);
  for (const Seen& seen : seen_) {
    for (const Eigen::Vector2d& point : seen.points) points.push_back(T_robot_map * point);
  }
  const auto cell_of = [&](const Eigen::Vector2d& p) {
    return std::pair(static_cast<int>(std::floor(p.y() / options_.point_spacing)),
                     static_cast<int>(std::floor(p.x() / options_.point_spacing)));
  };
  std::stable_sort(points.begin(), points.end(), [&](const auto& a, const auto& b) { return cell_of(a) < cell_of(b); });
  points.erase(
      std::unique(points.begin(), points.end(), [&](const auto& a, const auto& b) { return cell_of(a) == cell_of(b); }),
      points.end());
  return points;
}

void PlanLocalizer::Move(const Pose2& motion) {
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    Noise noise(Mix(options_.seed, Mix(static_cast<std::uint64_t>(FilterDraw::kMotion), step_), i));
    PlanState& state = particles_[i].state;
    state = Disturbed(Moved(state, motion, field_.axis()), motion, noise, options_);
  }
}

void PlanLocalizer::Weigh(const PlanLook& look) {
  since_update_ = 0;
  turned_ = 0;
  // Cells say too little of a short drive to tell places from one another.
  const bool is_placed = last_sure_.has_value();
  const PlanLikelihood likelihood =
      options_.sight == PlanSight::kNdt && is_placed
          ? PlanLikelihood::OfCells(NdtOf(RecentPoints(look.T_map_robot), options_.cell), options_)
          : PlanLikelihood::OfHits(look.hits, options_);
  if (likelihood.empty()) return;
  double mean = 0;
  for (PlanParticle& particle : particles_) {
    const double value = std::exp(likelihood.LogAt(field_, particle.state));
    mean += particle.weight * value;
    particle.weight *= value;
  }
  Normalise(particles_);
  slow_ = slow_ > 0 ? slow_ + options_.alpha_slow * (mean - slow_) : mean;
  fast_ = fast_ > 0 ? fast_ + options_.alpha_fast * (mean - fast_) : mean;
  if (EffectiveCount(particles_) < 0.5 * static_cast<double>(particles_.size())) Resample();
  const bool surveying = pairs_.empty() && options_.survey_share > 0 && travelled_ <= options_.survey_until && !proven_;
  if (surveying && travelled_ - surveyed_ >= options_.survey_distance) Survey();
}

void PlanLocalizer::Survey() {
  surveyed_ = travelled_;
  ++surveys_;
  const auto count = static_cast<std::size_t>(options_.survey_share * static_cast<double>(particles_.size()));
  if (count == 0 || !T_map_last_) return;
  std::vector<PlanParticle> found = StartAnywhere(
      field_, RecentPoints(*T_map_last_), {count, Mix(step_, kSurveyRound), kSurveyDensity}, options_, keep_going_);
  if (!found.empty()) rivals_.Remember(ModesOf(found, field_.axis(), options_), *T_map_last_);
  for (PlanParticle& particle : particles_) particle.weight *= 1 - options_.survey_share;
  for (PlanParticle& particle : found) {
    particle.weight *= options_.survey_share;
    particles_.push_back(particle);
  }
}

void PlanLocalizer::Resample() {
  const auto draw = [&](FilterDraw what) {
    return Noise(Mix(options_.seed, Mix(static_cast<std::uint64_t>(what), step_)));
  };
  const auto most = static_cast<std::size_t>(sure_ ? options_.most_particles : options_.most_unsure);
  particles_ = Resampled(particles_, most, draw(FilterDraw::kResample).Uniform(), options_);
  if (last_sure_ && travelled_ - *last_sure_ < options_.recovery_distance) return;
  const double share = slow_ > 0 ? std::clamp(1 - fast_ / slow_, 0.0, options_.most_recovered) : 0;
  const auto count = static_cast<std::size_t>(share * static_cast<double>(particles_.size()));
  if (options_.alpha_slow <= 0 || count == 0 || !T_map_last_) return;
  const std::vector<PlanParticle> found =
      StartAnywhere(field_, RecentPoints(*T_map_last_), {count, step_, kRecoveryDensity}, options_, keep_going_);
  // They take the places of particles spread evenly over all.
  for (std::size_t i = 0; i < found.size(); ++i) {
    particles_[i * particles_.size() / found.size()].state = found[i].state;
  }
}

void PlanLocalizer::Gate(const PlanState& state, const Eigen::Matrix3d& covariance) {
  Eigen::Matrix3d spread = covariance;
  spread.diagonal() += Eigen::Vector3d(options_.sigma_floor, options_.sigma_floor, options_.yaw_floor).cwiseAbs2();
  const Eigen::Matrix3d information = spread.inverse();
  const Eigen::Matrix2d metres = MetresOf(state, field_.axis());
  std::vector<PlanParticle> near = particles_;
  double left = 0;
  for (PlanParticle& particle : near) {
    const Eigen::Vector2d off = metres * (particle.state.translation() - state.translation());
    const Eigen::Vector3d error(off.x(), off.y(), WrapAngle(particle.state.yaw - state.yaw));
    if (particle.state.mirrored != state.mirrored || error.dot(information * error) > kGateQuantile)
      particle.weight = 0;
    left += particle.weight;
  }
  if (left <= 0) return;
  particles_ = std::move(near);
  Normalise(particles_);
}

PlanPosterior PlanLocalizer::Report(const PlanLook& look) {
  PlanPosterior posterior;
  posterior.travelled = travelled_;
  posterior.particles = particles_.size();
  if (particles_.empty()) return posterior;
  posterior.effective = EffectiveCount(particles_);
  posterior.modes = ModesOf(particles_, field_.axis(), options_);
  const PlanMode& best = posterior.modes.front();
  const PlanLikelihood hits = PlanLikelihood::OfHits(look.hits, options_);
  const double matched = hits.MatchedAt(field_, best.mean);
  matched_ = matched_ > 0 ? matched_ + kMatchedGain * (matched - matched_) : matched;
  posterior.matched = matched_;
  const bool is_held = IsHeld(best);
  posterior.proven = !IsRivalled() || IsProven(posterior.modes, look.T_map_robot);
  sure_ = is_held && posterior.proven;
  if (sure_) last_sure_ = travelled_;
  posterior.confident = sure_;
  return posterior;
}

// Whether the mode looks certain, and has done so for a while.
bool PlanLocalizer::IsHeld(const PlanMode& best) {
  if (best.mass < (sure_ ? options_.lasting_mass : options_.confident_mass) || !IsNarrow(best, options_)) {
    holding_since_.reset();
  } else if (!holding_since_) {
    holding_since_ = travelled_;
  }
  return holding_since_ && travelled_ - *holding_since_ >= options_.confident_distance &&
         matched_ >= options_.confident_match && IsSearched();
}

// Whether it was looked for everywhere often enough.
bool PlanLocalizer::IsSearched() const {
  return !pairs_.empty() || options_.survey_share <= 0 || surveys_ >= kLeastSurveys;
}

bool PlanLocalizer::IsProven(const std::vector<PlanMode>& modes, const Pose2& T_map_robot) {
  const bool is_due =
      IsSearched() && (!proven_ || travelled_ >= std::min((1 + kProvenShare) * proven_at_, proven_at_ + kProvenFor) ||
                       !IsAtProven(modes.front(), T_map_robot));
  if (is_due && travelled_ >= next_judged_) Judge(modes, T_map_robot);
  return IsAtProven(modes.front(), T_map_robot);
}

bool PlanLocalizer::IsAtProven(const PlanMode& mode, const Pose2& T_map_robot) const {
  if (!proven_ || proven_->mirrored() != mode.mean.mirrored) return false;
  const PlanState state = StateAt(field_, *proven_, T_map_robot);
  const double off = (MetresOf(mode.mean, field_.axis()) * (mode.mean.translation() - state.translation())).norm();
  return off <= kSameRobot + kSameRobotPerMetre * (travelled_ - proven_at_) &&
         std::abs(WrapAngle(mode.mean.yaw - state.yaw)) <= kSameTurn;
}

void PlanLocalizer::Judge(const std::vector<PlanMode>& modes, const Pose2& T_map_robot) {
  next_judged_ = travelled_ + std::max(kJudgedEach, kJudgedShare * travelled_);
  const PlaceVerdict verdict = rivals_.Compare(modes, T_map_robot, !proven_);
  if (verdict.proven) {
    proven_ = verdict.proven;
    proven_at_ = travelled_;
  }
  if (verdict.likelier.empty()) return;
  if (!verdict.proven) proven_.reset();
  MoveTo(verdict.likelier, T_map_robot);
}

// Most of the weight goes to places that are likelier than where it is now.
void PlanLocalizer::MoveTo(const std::vector<PlanTransform>& places, const Pose2& T_map_robot) {
  for (PlanParticle& particle : particles_) particle.weight *= 1 - kMovedShare;
  const double weight = kMovedShare / static_cast<double>(kMovedParticles * places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    const PlanState state = StateAt(field_, places[i], T_map_robot);
    for (std::size_t k = 0; k < kMovedParticles; ++k) {
      const Noise noise(
          Mix(options_.seed, Mix(static_cast<std::uint64_t>(FilterDraw::kMoved), step_), i * kMovedParticles + k));
      particles_.push_back({Spread(state, noise, options_), weight});
    }
  }
  holding_since_.reset();
}

}  // namespace enfilade::prior
