// SPDX-License-Identifier: Apache-2.0
#include "core/prior/alignment/align.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/prior/alignment/plan_shapes.h"
#include "core/prior/alignment/refine.h"
#include "core/prior/alignment/sheet_search.h"

namespace enfilade::prior {
namespace {

// The search compares coarse images for all shapes, then finer ones for the best.
constexpr int kCoarseCells = 64;
constexpr int kFineCells = 128;
constexpr std::size_t kMostShapes = 200;      // that are compared in fine images
constexpr std::size_t kMostCandidates = 200;  // refined quickly
constexpr std::size_t kMostFinalists = 20;    // refined well
constexpr std::size_t kQuickPoints = 500;
constexpr double kSamePlace = 1.0;      // m
constexpr double kUsualScale = 1.3;     // by which plans are larger or smaller than their files say
constexpr double kOneDirection = 0.02;  // of the walls' lengths that lie in another direction

struct Candidate {
  PlanTransform transform;
  TransformModel model = TransformModel::kSimilarity;
  double score = 0;
  Agreement agreement;
};

double ScoreOf(const Agreement& agreement) { return agreement.nearness * (1 - agreement.contradicted()); }

class Aligner {
 public:
  Aligner(const PlanGraph& plan, const MapEvidence& evidence, const AlignOptions& options)
      : faces_(FacesOf(plan)), evidence_(evidence), options_(options) {
    for (const PlanCorner& corner : plan.corners) corners_.push_back(corner.point);
  }

  // The mean distance between where two transforms place the plan's corners that the first one puts into the map.
  double Apart(const PlanTransform& a, const PlanTransform& b) const {
    double sum = 0;
    int count = 0;
    for (const Eigen::Vector2d& corner : corners_) {
      if (evidence_.WallDistanceAt(a(corner)) > 2.0) continue;
      sum += (a(corner) - b(corner)).norm();
      ++count;
    }
    return count > 0 ? sum / count : kSamePlace * 10;
  }

  // The best places of a search, refined; not sorted.
  std::vector<Candidate> Finalists(Stretch stretch) const {
    std::vector<Candidate> candidates = Search(stretch);
    RefineAll(candidates, {.widest = 3.0, .narrowest = 0.5, .rounds = 10, .most_points = kQuickPoints});
    candidates = Distinct(candidates, kSamePlace, kMostFinalists);
    for (Candidate& candidate : candidates) candidate = BestModel(candidate, 1.5);
    return candidates;
  }

  // The finalists of one search or several, the best first, each place once.
  std::vector<Candidate> Ranked(std::vector<Candidate> candidates) const {
    Sort(candidates);
    candidates = Distinct(candidates, kSamePlace, kMostFinalists);
    if (candidates.empty()) return candidates;
    candidates.front() = Simplest(candidates.front());
    Sort(candidates);
    return candidates;
  }

  void RefineAll(std::vector<Candidate>& candidates, const RefineOptions& options) const {
    for (Candidate& candidate : candidates) {
      candidate.transform = Refine(faces_, evidence_, candidate.transform, options);
      Judge(candidate);
    }
    Sort(candidates);
  }

  void Judge(Candidate& candidate) const {
    candidate.agreement = Compare(FaceIndex(Transformed(faces_, candidate.transform), kReach), evidence_);
    candidate.score = ScoreOf(candidate.agreement);
  }

  // The simplest model, from that of the start on, that explains the map nearly as well as any.
  Candidate BestModel(const Candidate& start, double widest) const {
    Candidate best = start;
    for (const TransformModel model :
         {TransformModel::kSimilarity, TransformModel::kAnisotropic, TransformModel::kAffine}) {
      if (FreedomOf(model) > FreedomOf(options_.widest_model)) break;
      Candidate next = best;
      next.model = std::max(model, start.model);
      next.transform = Refine(faces_, evidence_, best.transform,
                              {.model = model, .widest = model == TransformModel::kSimilarity ? widest : 1.0});
      Judge(next);
      const double most_left = model <= start.model ? 1.0 : options_.most_left;
      if (model == TransformModel::kSimilarity || 1 - next.score < most_left * (1 - best.score)) best = next;
    }
    return best;
  }

  // The place without its distortion, if that explains the map nearly as well.
  Candidate Simplest(const Candidate& candidate) const {
    if (candidate.model == TransformModel::kSimilarity) return candidate;
    Candidate simple{.transform = AsSimilarity(candidate.transform, map_centre()), .agreement = {}};
    simple = BestModel(simple, 1.5);
    return 1 - candidate.score < options_.most_left * (1 - simple.score) ? candidate : simple;
  }

  std::vector<Candidate> Distinct(const std::vector<Candidate>& sorted, double apart, std::size_t most) const {
    std::vector<Candidate> distinct;
    for (const Candidate& candidate : sorted) {
      if (distinct.size() == most) break;
      const bool is_new = std::none_of(distinct.begin(), distinct.end(), [&](const Candidate& other) {
        return other.transform.mirrored() == candidate.transform.mirrored() &&
               Apart(other.transform, candidate.transform) < apart;
      });
      if (is_new) distinct.push_back(candidate);
    }
    return distinct;
  }

  static void Sort(std::vector<Candidate>& candidates) {
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  }

  // Whether all walls that it explains are parallel: they do not tell where along them it lies.
  bool IsOpenAlongWalls(const PlanTransform& transform) const {
    const FaceIndex index(Transformed(faces_, transform), kReach);
    Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
    for (const WallPoint& wall : evidence_.walls) {
      if (wall.straightness < kStraight) continue;
      const auto nearest = index.Nearest(wall.point, wall.along, kParallel);
      if (nearest && nearest->distance <= kExplainedDistance) sum += wall.along * wall.along.transpose();
    }
    const Eigen::Vector2d lengths = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(sum).eigenvalues();
    return lengths(0) < kOneDirection * lengths(1);
  }

  Eigen::Vector2d map_centre() const {
    const Eigen::Vector2d size(evidence_.geometry.width, evidence_.geometry.height);
    return evidence_.geometry.T_map_grid * (0.5 * evidence_.geometry.resolution * size);
  }

  double search_radius() const {
    return 0.5 * evidence_.geometry.resolution * std::hypot(evidence_.geometry.width, evidence_.geometry.height);
  }

  static constexpr double kReach = 1.5;  // m

 private:
  std::vector<Candidate> Search(Stretch stretch) const {
    const SheetSearch coarse(faces_, evidence_, kCoarseCells);
    const std::vector<PlanShape> shapes =
        options_.known_shape
            ? TurnsOf(*options_.known_shape, faces_, evidence_, {1 - kKnownScale, 1.0, 1 + kKnownScale})
            : ShapesToTry(faces_, evidence_, coarse.Scales(), stretch);
    const std::vector<PlanShape> likely = BestShapes(FindAll(coarse, shapes));
    return Distinct(FindAll(SheetSearch(faces_, evidence_, kFineCells), likely), 0.03 * search_radius(),
                    kMostCandidates);
  }

  // The shapes of the best candidates, each once. `sorted`: the best candidate first.
  static std::vector<PlanShape> BestShapes(const std::vector<Candidate>& sorted) {
    std::vector<PlanShape> shapes;
    for (const Candidate& candidate : sorted) {
      if (shapes.size() == kMostShapes) break;
      const bool is_new = std::none_of(shapes.begin(), shapes.end(), [&](const PlanShape& other) {
        return other.linear == candidate.transform.linear;
      });
      if (is_new) shapes.push_back({candidate.transform.linear, candidate.model});
    }
    return shapes;
  }

  // The best offsets of each shape, the best of all first.
  static std::vector<Candidate> FindAll(const SheetSearch& search, const std::vector<PlanShape>& shapes) {
    std::vector<Candidate> found;
    for (const PlanShape& shape : shapes) {
      for (const FoundTransform& place : search.Find(shape.linear)) {
        found.push_back({.transform = place.T_map_sheet, .model = shape.model, .score = place.score, .agreement = {}});
      }
    }
    Sort(found);
    return found;
  }

  std::vector<WallFace> faces_;
  std::vector<Eigen::Vector2d> corners_;
  const MapEvidence& evidence_;
  const AlignOptions& options_;
};

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

// `within`: m, how far the start may be from where the plan lies.
Alignment RefinedFrom(const Aligner& aligner, Candidate start, double within) {
  aligner.Judge(start);
  const Candidate refined = aligner.BestModel(start, within);
  return ToAlignment(refined.score >= start.score ? refined : start);
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

// Whether the best of some places is believed. `ranked`: the best one first.
Alignment Verdict(const PlanGraph& plan, const std::vector<Candidate>& ranked, const AlignOptions& options) {
  if (ranked.empty()) return {.reason = "no place on the plan fits", .T_map_sheet = {}, .agreement = {}};
  Alignment alignment = ToAlignment(ranked.front());
  const double rival = ranked.size() > 1 ? ranked[1].score : 0;
  alignment.rival_ratio = rival > 0 ? ranked.front().score / rival : 99;
  alignment.reason = ObjectionTo(alignment, options);
  const bool could_be_straight = alignment.T_map_sheet.mirrored() && !options.known_shape;
  const bool sure = alignment.agreement.explained >= options.sure_explained &&
                    alignment.agreement.contradicted() <= options.sure_contradicted;
  const double needed =
      (sure ? options.sure_rival_ratio : options.least_rival_ratio) * (could_be_straight ? options.mirror_gain : 1);
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
  ENFILADE_ASSIGN_OR_RETURN(const PairFit fit, FitPairs(pairs, (max - min).norm()));
  const Aligner aligner(plan, evidence, options);
  Alignment alignment = RefinedFrom(aligner, {.transform = fit.T_map_sheet, .model = fit.model, .agreement = {}}, 3.0);
  for (const PlanTransform& other : fit.others) {
    if (!IsAllowed(other, options)) continue;
    Alignment next =
        RefinedFrom(aligner, {.transform = other, .model = TransformModel::kAnisotropic, .agreement = {}}, 3.0);
    if (IsBetter(next, alignment, options)) alignment = std::move(next);
  }
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
  Alignment alignment = RefinedFrom(aligner, {.transform = start, .agreement = {}}, 1.0);
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
  std::vector<Candidate> candidates = aligner.Ranked(aligner.Finalists(Stretch::kNone));
  Alignment alignment = Verdict(plan, candidates, options);
  if (alignment.accepted || options.known_shape || options.widest_model != TransformModel::kAffine) return alignment;
  // With more freedom wrong plans fit better, too, so more is asked of a place.
  AlignOptions strict = options;
  strict.least_explained = options.sure_explained;
  strict.most_contradicted = options.sure_contradicted;
  for (Candidate& stretched : aligner.Finalists(Stretch::kAlongWalls)) candidates.push_back(std::move(stretched));
  Alignment stretched = Verdict(plan, aligner.Ranked(std::move(candidates)), strict);
  return stretched.accepted ? stretched : alignment;
}

}  // namespace enfilade::prior
