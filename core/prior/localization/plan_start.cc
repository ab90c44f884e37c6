// SPDX-License-Identifier: Apache-2.0
#include "core/prior/localization/plan_start.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <complex>

#include "core/base/error.h"
#include "core/base/noise.h"
#include "core/base/status_macros.h"
#include "core/prior/localization/ndt_map.h"
#include "core/prior/plan/directions.h"

namespace enfilade::prior {
namespace {

using Complex = std::complex<double>;

// What random numbers are for.
enum class Draw : std::uint64_t { kPairs = 101, kPlaces = 102, kKept = 103, kSpread = 104 };

Noise NoiseOf(const PlanLocalizerOptions& options, Draw draw, std::uint64_t index) {
  return Noise(Mix(options.seed, static_cast<std::uint64_t>(draw), index));
}

Complex ToComplex(const Eigen::Vector2d& p) { return {p.x(), p.y()}; }

void DrawScales(PlanState& state, Noise& noise, const PlanLocalizerOptions& options) {
  const double first = noise.Uniform(-options.scale_spread, options.scale_spread);
  const double second = noise.Uniform(-options.scale_spread, options.scale_spread);
  if (!options.free_scale) return;
  state.log_scale = 0.5 * (first + second);
  state.log_stretch = 0.5 * (first - second);
}

double UsualDoor(const PlanGraph& plan) {
  std::vector<double> widths;
  for (const PlanDoor& door : plan.doors) widths.push_back((door.to - door.from).norm());
  if (widths.empty()) return 0;
  const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
  std::nth_element(widths.begin(), middle, widths.end());
  return *middle;
}

double SizeOf(const PlanGraph& plan) {
  Eigen::Vector2d low = plan.corners.front().point;
  Eigen::Vector2d high = low;
  for (const PlanCorner& corner : plan.corners) {
    low = low.cwiseMin(corner.point);
    high = high.cwiseMax(corner.point);
  }
  return (high - low).norm();
}

}  // namespace

absl::StatusOr<double> NominalScale(const PlanGraph& plan, const std::vector<ControlPair>& pairs) {
  if (plan.walls.empty()) return InvalidArgument("the plan has no walls");
  double scale = plan.metres_per_unit.value_or(0);
  if (pairs.size() == 1 && !(pairs[0].point_sheet.allFinite() && pairs[0].point_map.allFinite())) {
    return InvalidArgument("pair 1 has a number that is not finite");
  }
  if (pairs.size() >= 2) {
    ENFILADE_ASSIGN_OR_RETURN(const PairFit fit, FitPairs(pairs, SizeOf(plan)));
    scale = fit.T_map_sheet.scale();
  } else if (scale <= 0) {
    const double door = UsualDoor(plan);
    if (door <= 0) return InvalidArgument("the plan does not tell its scale, and has no doors: measure a length in it");
    scale = kUsualDoor / door;
  }
  if (!(SizeOf(plan) * scale < kLargestField)) {
    return InvalidArgument("the plan is {:.0f} m wide; at most {:.0f} m can be searched", SizeOf(plan) * scale,
                           kLargestField);
  }
  return scale;
}

std::vector<PlanParticle> StartAtPairs(const PlanField& field, const std::vector<ControlPair>& pairs,
                                       const Pose2& T_map_robot, std::size_t count,
                                       const PlanLocalizerOptions& options) {
  std::vector<PlanParticle> particles;
  for (std::size_t i = 0; i < count; ++i) {
    Noise noise = NoiseOf(options, Draw::kPairs, i);
    PlanState state;
    state.mirrored = noise.Chance(options.mirrored_share);
    if (pairs.size() < 2) DrawScales(state, noise, options);
    const double stretch = options.stretch_sigma * noise.Normal();
    if (pairs.size() >= 2 && options.free_scale) state.log_stretch = stretch;
    // In metres along the plan's directions, by the scales known so far: point = factor * map + shift.
    const Eigen::Matrix2d metres = MetresOf(state, field.axis());
    const auto map_of = [&](const Eigen::Vector2d& point) {
      return state.mirrored ? std::conj(ToComplex(point)) : ToComplex(point);
    };
    std::vector<Complex> map;
    std::vector<Complex> plan;
    Complex map_middle;
    Complex plan_middle;
    for (const ControlPair& pair : pairs) {
      const double x = options.click_sigma * noise.Normal();
      const double y = options.click_sigma * noise.Normal();
      map.push_back(map_of(pair.point_map + Eigen::Vector2d(x, y)));
      plan.push_back(ToComplex(metres * field.ToPlan(pair.point_sheet)));
      map_middle += map.back() / static_cast<double>(pairs.size());
      plan_middle += plan.back() / static_cast<double>(pairs.size());
    }
    Complex factor = std::polar(1.0, noise.Uniform(-M_PI, M_PI));
    if (pairs.size() >= 2) {
      Complex both;
      double squares = 0;
      for (std::size_t k = 0; k < pairs.size(); ++k) {
        both += std::conj(map[k] - map_middle) * (plan[k] - plan_middle);
        squares += std::norm(map[k] - map_middle);
      }
      factor = both / std::max(squares, 1e-9);
      if (options.free_scale) {
        state.log_scale = std::clamp(-std::log(std::max(std::abs(factor), 1e-9)), -0.7, 0.7);
      } else {
        factor /= std::max(std::abs(factor), 1e-9);
      }
    }
    const Complex robot = plan_middle + factor * (map_of(T_map_robot.translation()) - map_middle);
    // `robot` is in metres by the stretch alone if pairs tell the scale.
    const Eigen::Vector2d at = metres.inverse() * Eigen::Vector2d(robot.real(), robot.imag());
    state.x = at.x();
    state.y = at.y();
    state.yaw = WrapAngle(std::arg(factor) + (state.mirrored ? -T_map_robot.yaw : T_map_robot.yaw));
    particles.push_back({state, 1.0 / static_cast<double>(count)});
  }
  return particles;
}

PlanState Spread(PlanState state, Noise noise, const PlanLocalizerOptions& options) {
  constexpr double kAside = 0.15;  // m
  constexpr double kTurned = 0.05;
  constexpr double kScaled = 0.03;
  state.x += kAside * noise.Normal();
  state.y += kAside * noise.Normal();
  state.yaw = WrapAngle(state.yaw + kTurned * noise.Normal());
  if (!options.free_scale) return state;
  state.log_scale += kScaled * noise.Normal();
  state.log_stretch += kScaled * noise.Normal();
  return state;
}

namespace {

// The direction that most walls have, by the long cells of the normal distributions of what was seen, rad.
std::optional<double> DirectionOf(const std::vector<Eigen::Vector2d>& seen, const PlanLocalizerOptions& options) {
  constexpr double kLong = 10;  // ratio of variances
  std::vector<WeightedDirection> lines;
  for (const NdtCell& cell : NdtOf(seen, options.cell)) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(cell.covariance);
    if (solver.eigenvalues().y() < kLong * solver.eigenvalues().x()) continue;
    lines.push_back({solver.eigenvectors().col(1), static_cast<double>(cell.points)});
  }
  if (lines.empty()) return std::nullopt;
  const std::vector<double> directions = DominantDirections(lines);
  return directions.empty() ? std::nullopt : std::optional(directions.front());
}

// `direction`: that most walls have in the robot's frame; along the plan's axis or across it in most places.
PlanState AnyPlace(const PlanField& field, const std::optional<double>& direction, Noise noise,
                   const PlanLocalizerOptions& options) {
  constexpr double kTurnSigma = 0.05;  // rad
  PlanState state;
  state.x = noise.Uniform(field.min().x(), field.max().x());
  state.y = noise.Uniform(field.min().y(), field.max().y());
  state.yaw = noise.Uniform(-M_PI, M_PI);
  state.mirrored = noise.Chance(options.mirrored_share);
  if (direction && noise.Chance(options.global_aligned)) {
    const double quarters = noise.Below(4) * M_PI / 2;
    const double turned = state.mirrored ? *direction : -*direction;
    state.yaw = WrapAngle(field.axis() + turned + quarters + kTurnSigma * noise.Normal());
  }
  DrawScales(state, noise, options);
  return state;
}

// What the logarithms in `logs` weigh.
std::vector<double> WeightsOf(const std::vector<float>& logs) {
  const float best = *std::max_element(logs.begin(), logs.end());
  std::vector<double> weights;
  weights.reserve(logs.size());
  for (const float log : logs) weights.push_back(std::exp(static_cast<double>(log - best)));
  return weights;
}

}  // namespace

std::vector<PlanParticle> StartAnywhere(const PlanField& field, const std::vector<Eigen::Vector2d>& seen,
                                        const WideSearch& search, const PlanLocalizerOptions& options,
                                        const KeepGoing& keep_going) {
  constexpr std::size_t kTriedAtOnce = 20'000;  // places, between two questions
  PlanLocalizerOptions wide = options;
  wide.sum = BeamSum::kTempered;
  wide.z_rand = 1 - wide.z_hit;
  wide.sigma_plan = options.global_sigma;
  wide.effective_beams = options.global_beams;
  PlanLocalizerOptions narrow = wide;
  narrow.sigma_plan = 0.5 * options.global_sigma;
  wide.beams = std::max(1, options.beams / 2);
  const PlanLikelihood widely = PlanLikelihood::OfHits(seen, wide);
  const PlanLikelihood narrowly = PlanLikelihood::OfHits(seen, narrow);

  const Eigen::Vector2d size = field.max() - field.min();
  const auto tried =
      static_cast<std::size_t>(std::clamp(search.density * size.x() * size.y(), static_cast<double>(search.count),
                                          static_cast<double>(options.most_global)));
  const std::optional<double> direction = DirectionOf(seen, options);
  const auto place = [&](std::size_t i) {
    return AnyPlace(field, direction, NoiseOf(options, Draw::kPlaces, Mix(search.round, i)), options);
  };
  std::vector<float> logs(tried);
  for (std::size_t i = 0; i < tried; ++i) {
    if (i % kTriedAtOnce == 0 && keep_going && !keep_going().ok()) return {};
    logs[i] = static_cast<float>(widely.LogAt(field, place(i)));
  }
  Noise random = NoiseOf(options, Draw::kKept, search.round);
  const std::size_t kept = std::min(tried, 4 * search.count);
  std::vector<PlanState> states;
  for (const std::size_t i : LowVarianceSample(WeightsOf(logs), kept, random.Uniform())) {
    states.push_back(Spread(place(i), NoiseOf(options, Draw::kSpread, Mix(search.round, states.size())), options));
  }
  logs.clear();
  for (const PlanState& state : states) logs.push_back(static_cast<float>(narrowly.LogAt(field, state)));
  std::vector<PlanParticle> particles;
  for (const std::size_t i : LowVarianceSample(WeightsOf(logs), search.count, random.Uniform())) {
    particles.push_back({states[i], 1.0 / static_cast<double>(search.count)});
  }
  return particles;
}

}  // namespace enfilade::prior
