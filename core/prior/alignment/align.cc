// SPDX-License-Identifier: Apache-2.0
#include "core/prior/alignment/align.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/prior/alignment/aligner.h"
#include "core/prior/alignment/directions.h"
#include "core/prior/alignment/judged_places.h"

namespace enfilade::prior {
namespace {

constexpr double kAskew = 0.05;           // rad
constexpr double kUsualScale = 1.3;       // by which plans are larger or smaller than their files say
constexpr std::size_t kMostCompared = 8;  // places that are judged by evidence

Alignment ToAlignment(const Candidate& candidate) {
  Alignment alignment;
  alignment.T_map_sheet = candidate.transform;
  alignment.model = candidate.model;
  alignment.agreement = candidate.agreement;
  return alignment;
}

// What people should know of a place that is accepted.
std::string NoteOnScale(const PlanGraph& plan, const PlanTransform& transform) {
  if (!plan.metres_per_unit) return "";
  const double ratio = transform.scale() / *plan.metres_per_unit;
  if (ratio < kUsualScale && ratio > 1 / kUsualScale) return "";
  return fmt::format("; it is {:.3g} times as large as its file says", ratio);
}

// Why the place cannot be believed; empty: it can.
std::string ObjectionTo(const Alignment& alignment, const AlignOptions& options) {
  const Agreement& agreement = alignment.agreement;
  if (agreement.explained_length < options.least_length) {
    return fmt::format("the plan explains {:.0f} m of the map's walls, {:.0f} m are needed", agreement.explained_length,
                       options.least_length);
  }
  if (agreement.explained < options.least_explained) {
    return fmt::format("the plan explains {:.0f} % of the map's walls, {:.0f} % are needed", 100 * agreement.explained,
                       100 * options.least_explained);
  }
  if (agreement.contradicted() > options.most_contradicted) {
    return fmt::format("{:.0f} % of the plan's walls that the map knows lie in free ground, at most {:.0f} % may",
                       100 * agreement.contradicted(), 100 * options.most_contradicted);
  }
  return "";
}

// The same of a place that nobody has shown. Plans of other floors explain half of a map, too: its outer walls and
// shafts. They are contradicted by more than the right ones.
std::string ObjectionToFound(const Alignment& alignment, const AlignOptions& options) {
  const Agreement& agreement = alignment.agreement;
  std::string objection = ObjectionTo(alignment, options);
  if (!objection.empty() || agreement.explained >= options.sure_explained) return objection;
  if (agreement.contradicted() <= options.most_contradicted_unsure) return "";
  return fmt::format(
      "{:.0f} % of the plan's walls that the map knows lie in free ground, at most {:.0f} % may where it explains "
      "{:.0f} % of the map's walls",
      100 * agreement.contradicted(), 100 * options.most_contradicted_unsure, 100 * agreement.explained);
}

bool IsAllowed(const PlanTransform& transform, const AlignOptions& options) {
  return options.widest_model != TransformModel::kSimilarity || IsSimilarity(transform);
}

// Does it fit better, and if it is the more unusual of the two by as much as that takes?
bool IsBetter(const Alignment& next, const Alignment& best, const AlignOptions& options) {
  const double score = ScoreOf(next.agreement);
  const double known = ScoreOf(best.agreement);
  const bool mirrored = next.T_map_sheet.mirrored();
  if (mirrored != best.T_map_sheet.mirrored()) {
    return mirrored ? score > options.mirror_gain * known : options.mirror_gain * score > known;
  }
  return 1 - score < options.most_left * (1 - known);
}

// By how much one place that nobody has shown must fit better than any other.
double NeededRatio(const PlanTransform& transform, double ratio, const AlignOptions& options) {
  const bool could_be_straight = transform.mirrored() && !options.known_shape;
  return could_be_straight ? ratio * options.mirror_gain : ratio;
}

// Whether the best of some places is believed. `ranked`: the best one first.
Alignment Verdict(const PlanGraph& plan, const std::vector<Candidate>& ranked, const AlignOptions& options) {
  if (ranked.empty()) return {.reason = "no place on the plan fits", .T_map_sheet = {}, .agreement = {}};
  Alignment alignment = ToAlignment(ranked.front());
  const double rival = ranked.size() > 1 ? ranked[1].score : 0;
  alignment.rival_ratio = rival > 0 ? ranked.front().score / rival : 99;
  alignment.reason = ObjectionToFound(alignment, options);
  const bool sure = alignment.agreement.explained >= options.sure_explained &&
                    alignment.agreement.contradicted() <= options.sure_contradicted;
  const double needed =
      NeededRatio(alignment.T_map_sheet, sure ? options.sure_rival_ratio : options.least_rival_ratio, options);
  if (alignment.reason.empty() && alignment.rival_ratio < needed) {
    alignment.reason = fmt::format("another place fits nearly as well: {:.2f} times, {:.2f} are needed",
                                   alignment.rival_ratio, needed);
  }
  alignment.accepted = alignment.reason.empty();
  if (alignment.accepted)
    alignment.reason = fmt::format("fits {:.2f} times as well as any other place{}", alignment.rival_ratio,
                                   NoteOnScale(plan, alignment.T_map_sheet));
  return alignment;
}

// The places that fit nearly as well as the best, the likeliest first; none, if it is the only one or if they are too
// many. `ranked`: the best one first.
std::vector<JudgedPlace> TwinsOf(const PlanGraph& plan, const MapEvidence& evidence,
                                 const std::vector<Candidate>& ranked, const AlignOptions& options) {
  if (ranked.empty() || options.log_evidence == nullptr) return {};
  const auto end_of = [&](double ratio) {
    return std::find_if(ranked.begin(), ranked.end(),
                        [&](const Candidate& other) { return other.score * ratio <= ranked.front().score; });
  };
  auto end = end_of(options.least_rival_ratio);
  if (end - ranked.begin() == 1)
    end = end_of(NeededRatio(ranked.front().transform, options.least_rival_ratio, options));
  const auto count = static_cast<std::size_t>(end - ranked.begin());
  if (count < 2 || count > options.most_twins) return {};
  return JudgedByEvidence(plan, evidence, {ranked.begin(), end}, options);
}

// Whether of a few places that fit nearly alike the likeliest is believed: only if it also fits best, as a correction
// may have gone astray at one of them. `refused`: what is said of them else.
Alignment VerdictOnTwins(const PlanGraph& plan, const std::vector<JudgedPlace>& twins, const Alignment& refused,
                         const AlignOptions& options) {
  const Candidate& best = twins[0].place;
  const double margin = twins[0].evidence - twins[1].evidence;
  Alignment alignment = ToAlignment(best);
  if (margin < NeededEvidence(best.transform, twins[1].place.transform, options)) return refused;
  if (!ObjectionToFound(alignment, options).empty()) return refused;
  double rival = 0;
  for (auto other = twins.begin() + 1; other != twins.end(); ++other) rival = std::max(rival, other->place.score);
  alignment.log_odds = margin;
  alignment.rival_ratio = best.score / rival;
  if (alignment.rival_ratio < 1) return refused;
  alignment.accepted = true;
  alignment.reason = fmt::format(
      "another place fits nearly as well ({:.2f} times), but corrected there the plan is less likely (log odds "
      "{:.0f}){}",
      alignment.rival_ratio, margin, NoteOnScale(plan, alignment.T_map_sheet));
  return alignment;
}

// What the pairs say with the scales along and across the plan's walls instead of those of the sheet, if walls are
// askew on the sheet.
std::optional<PairFit> FitPairsAlongWalls(const PlanGraph& plan, std::vector<ControlPair> pairs, double sheet_size) {
  const double direction = MainDirection(FacesOf(plan));
  if (std::min(direction, M_PI / 2 - direction) < kAskew) return std::nullopt;
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(-direction).toRotationMatrix();
  for (ControlPair& pair : pairs) pair.point_sheet = turn * pair.point_sheet;
  absl::StatusOr<PairFit> fit = FitPairs(pairs, sheet_size);
  if (!fit.ok()) return std::nullopt;
  fit->T_map_sheet.linear *= turn;
  for (PlanTransform& other : fit->others) other.linear *= turn;
  if (fit->model == TransformModel::kAnisotropic) fit->model = TransformModel::kAffine;
  return *std::move(fit);
}

// m^2, of all pairs but a wrong one.
double SumOfSquares(const PairFit& fit) {
  const std::vector<double>& residuals = fit.residuals;
  const double all = std::inner_product(residuals.begin(), residuals.end(), residuals.begin(), 0.0);
  return fit.wrong ? all - residuals[*fit.wrong] * residuals[*fit.wrong] : all;
}

// Whether a place that fits better than any other is also likelier than those next to it. `ranked`: the best one first.
void Confirm(const PlanGraph& plan, const MapEvidence& evidence, const std::vector<Candidate>& ranked,
             const AlignOptions& options, Alignment& alignment) {
  if (options.log_evidence == nullptr || ranked.size() < 2) return;
  const std::size_t compared = std::min(ranked.size(), kMostCompared);
  const auto end = ranked.begin() + static_cast<std::ptrdiff_t>(compared);
  const std::vector<JudgedPlace> others = JudgedByEvidence(plan, evidence, {ranked.begin() + 1, end}, options);
  alignment.log_odds = options.log_evidence(plan, evidence, ranked.front().transform) - others.front().evidence;
  if (alignment.log_odds >= options.confirming_evidence) return;
  alignment.accepted = false;
  alignment.reason =
      fmt::format("corrected at another place the plan is nearly as likely: log odds {:.0f}, {:.0f} are needed",
                  alignment.log_odds, options.confirming_evidence);
}

}  // namespace

absl::StatusOr<Alignment> AlignByPairs(const PlanGraph& plan, const MapEvidence& evidence,
                                       const std::vector<ControlPair>& pairs, const AlignOptions& options) {
  if (plan.walls.empty()) return InvalidArgument("the plan has no walls");
  Eigen::Vector2d min = plan.corners.front().point;
  Eigen::Vector2d max = min;
  for (const PlanCorner& corner : plan.corners) {
    min = min.cwiseMin(corner.point);
    max = max.cwiseMax(corner.point);
  }
  const double sheet_size = (max - min).norm();
  ENFILADE_ASSIGN_OR_RETURN(PairFit fit, FitPairs(pairs, sheet_size, options.widest_model));
  const std::optional<PairFit> along_walls = FitPairsAlongWalls(plan, pairs, sheet_size);
  const std::vector<PlanTransform> along_sheet = fit.others;
  const bool is_stretched = along_walls && along_walls->model == TransformModel::kAffine;
  if (is_stretched && IsAllowed(along_walls->T_map_sheet, options) && SumOfSquares(*along_walls) < SumOfSquares(fit)) {
    fit = *along_walls;
  }
  const Aligner aligner(plan, evidence, options);
  Alignment alignment =
      ToAlignment(aligner.RefinedFrom({.transform = fit.T_map_sheet, .model = fit.model, .agreement = {}}, 3.0));
  const auto try_others = [&](const std::vector<PlanTransform>& others, TransformModel model) {
    for (const PlanTransform& other : others) {
      if (!IsAllowed(other, options)) continue;
      Alignment next = ToAlignment(aligner.RefinedFrom({.transform = other, .model = model, .agreement = {}}, 3.0));
      if (IsBetter(next, alignment, options)) alignment = std::move(next);
    }
  };
  try_others(along_sheet, TransformModel::kAnisotropic);
  if (along_walls) try_others(along_walls->others, TransformModel::kAffine);
  alignment.accepted = true;
  alignment.reason = fmt::format("{} pairs of points", pairs.size() - (fit.wrong ? 1 : 0));
  if (fit.wrong)
    alignment.reason +=
        fmt::format("; pair {} is {:.1f} m off and was left out", *fit.wrong + 1, fit.residuals[*fit.wrong]);
  if (aligner.IsOpenAlongWalls(alignment.T_map_sheet)) {
    alignment.reason += "; the walls are parallel: where along them it lies, only the pairs tell";
  }
  alignment.reason += NoteOnScale(plan, alignment.T_map_sheet);
  return alignment;
}

Alignment AlignFrom(const PlanGraph& plan, const MapEvidence& evidence, const PlanTransform& start,
                    const AlignOptions& options) {
  const Aligner aligner(plan, evidence, options);
  Alignment alignment = ToAlignment(aligner.RefinedFrom({.transform = start, .agreement = {}}, 1.0));
  alignment.reason = ObjectionTo(alignment, options);
  alignment.accepted = alignment.reason.empty();
  if (alignment.accepted) alignment.reason = "fits where it was placed before";
  return alignment;
}

Alignment AlignByItself(const PlanGraph& plan, const MapEvidence& evidence, const AlignOptions& options) {
  Alignment none;
  none.reason = "the map has no walls";
  if (evidence.walls.empty() || plan.walls.empty()) return none;
  const Aligner aligner(plan, evidence, options);
  const std::vector<Candidate> plain = aligner.Ranked(aligner.Finalists(Stretch::kNone));
  std::vector<Candidate> all = plain;
  Alignment alignment = Verdict(plan, plain, options);
  if (alignment.accepted && options.known_shape) Confirm(plan, evidence, plain, options, alignment);
  if (alignment.accepted) return alignment;
  // With more freedom wrong plans fit better, too, so more is asked of a place.
  AlignOptions strict = options;
  strict.least_explained = options.sure_explained;
  strict.most_contradicted = options.sure_contradicted;
  if (!options.known_shape && options.widest_model == TransformModel::kAffine) {
    for (Candidate& stretched : aligner.Finalists(Stretch::kAlongWalls)) all.push_back(std::move(stretched));
    all = aligner.Ranked(std::move(all));
    const Alignment stretched = Verdict(plan, all, strict);
    if (stretched.accepted) return stretched;
  }
  const std::vector<JudgedPlace> twins = TwinsOf(plan, evidence, all, options);
  if (twins.empty()) return alignment;
  const bool found_plain = std::any_of(plain.begin(), plain.end(), [&](const Candidate& candidate) {
    return aligner.IsSamePlace(candidate.transform, twins.front().place.transform);
  });
  return VerdictOnTwins(plan, twins, alignment, found_plain ? options : strict);
}

}  // namespace enfilade::prior
