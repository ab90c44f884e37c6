// SPDX-License-Identifier: Apache-2.0
#include "core/prior/alignment/aligner.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/parallel.h"
#include "core/prior/alignment/directions.h"
#include "core/prior/alignment/sheet_search.h"

namespace enfilade::prior {
namespace {

// The search compares coarse images for all shapes, then finer ones for the best.
constexpr int kCoarseCells = 64;
constexpr int kFineCells = 128;
constexpr std::size_t kMostShapes = 200;      // that are compared in fine images
constexpr std::size_t kMostCandidates = 200;  // refined quickly
constexpr std::size_t kMostFinalists = 20;    // refined well
constexpr std::size_t kMostTwins = 4;         // refined well
constexpr std::size_t kQuickPoints = 500;
constexpr double kSamePlace = 1.0;      // m
constexpr double kJudgedReach = 1.5;    // m
constexpr double kOneDirection = 0.02;  // of the walls' lengths that lie in another direction

RefineOptions Quickly(const AlignOptions& options) {
  return {.model = options.known_shape ? TransformModel::kRigid : TransformModel::kSimilarity,
          .widest = 3.0,
          .narrowest = 0.5,
          .rounds = 10,
          .most_points = kQuickPoints};
}

void SortByScore(std::vector<Candidate>& candidates) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
}

// The shapes of the best candidates, each once. `sorted`: the best candidate first.
std::vector<PlanShape> BestShapes(const std::vector<Candidate>& sorted) {
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
std::vector<Candidate> FindAll(const SheetSearch& search, const std::vector<PlanShape>& shapes,
                               const AlignOptions& options) {
  std::vector<std::vector<FoundTransform>> places(shapes.size());
  ForEachIndex(shapes.size(), options.threads, [&](std::size_t i) {
    if (!IsStopped(options)) places[i] = search.Find(shapes[i].linear);
  });
  std::vector<Candidate> found;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    for (const FoundTransform& place : places[i]) {
      found.push_back({place.T_map_sheet, shapes[i].model, place.score, {}});
    }
  }
  SortByScore(found);
  return found;
}

}  // namespace

double ScoreOf(const Agreement& agreement) { return agreement.nearness * (1 - agreement.contradicted()); }

Aligner::Aligner(const PlanGraph& plan, const MapEvidence& evidence, const AlignOptions& options)
    : faces_(FacesOf(plan)), evidence_(evidence), options_(options) {
  for (const PlanCorner& corner : plan.corners) corners_.push_back(corner.point);
}

// The mean distance between where two transforms place the plan's corners that the first one puts into the map.
double Aligner::Apart(const PlanTransform& a, const PlanTransform& b) const {
  double sum = 0;
  int count = 0;
  for (const Eigen::Vector2d& corner : corners_) {
    if (evidence_.WallDistanceAt(a(corner)) > 2.0) continue;
    sum += (a(corner) - b(corner)).norm();
    ++count;
  }
  return count > 0 ? sum / count : kSamePlace * 10;
}

bool Aligner::IsSamePlace(const PlanTransform& a, const PlanTransform& b) const {
  return a.mirrored() == b.mirrored() && Apart(a, b) < kSamePlace;
}

std::vector<Candidate> Aligner::Search(Stretch stretch) const {
  const SheetSearch coarse(faces_, evidence_, kCoarseCells);
  const std::vector<double> scales = options_.known_scales
                                         ? ScalesBetween(options_.known_scales->first, options_.known_scales->second)
                                         : coarse.Scales();
  const std::vector<PlanShape> shapes =
      options_.known_shape ? TurnsOf(*options_.known_shape, faces_, evidence_, {1 - kKnownScale, 1.0, 1 + kKnownScale})
                           : ShapesToTry(faces_, evidence_, scales, stretch);
  const std::vector<PlanShape> likely = BestShapes(FindAll(coarse, shapes, options_));
  return Distinct(FindAll(SheetSearch(faces_, evidence_, kFineCells), likely, options_), 0.03 * search_radius(),
                  kMostCandidates);
}

std::vector<Candidate> Aligner::Finalists(Stretch stretch) const {
  std::vector<Candidate> candidates = Search(stretch);
  RefineAll(candidates, Quickly(options_));
  candidates = Distinct(candidates, kSamePlace, kMostFinalists);
  ForEachIndex(candidates.size(), options_.threads,
               [&](std::size_t i) { candidates[i] = BestModel(candidates[i], 1.5); });
  return candidates;
}

// Many buildings look nearly the same turned by half, or turned over along or across their walls. The search, which
// knows the axes' scales coarsely, may miss such a place although it finds another: here both are as well known.
std::vector<Candidate> Aligner::Twins(const Candidate& candidate) const {
  const Eigen::Matrix2d axes = Eigen::Rotation2Dd(MainDirection(faces_)).toRotationMatrix();
  std::vector<PlanShape> shapes;
  for (const Eigen::Vector2d& signs : {Eigen::Vector2d(-1, -1), Eigen::Vector2d(1, -1), Eigen::Vector2d(-1, 1)}) {
    if (options_.known_shape && signs.prod() < 0) continue;  // which is known to be mirrored or not
    shapes.push_back({candidate.transform.linear * axes * signs.asDiagonal() * axes.transpose(), candidate.model});
  }
  std::vector<Candidate> twins = FindAll(SheetSearch(faces_, evidence_, kFineCells), shapes, options_);
  RefineAll(twins, Quickly(options_));
  twins = Distinct(twins, kSamePlace, kMostTwins);
  ForEachIndex(twins.size(), options_.threads, [&](std::size_t i) { twins[i] = BestModel(twins[i], 1.5); });
  return twins;
}

std::vector<Candidate> Aligner::Ranked(std::vector<Candidate> candidates) const {
  SortByScore(candidates);
  candidates = Distinct(candidates, kSamePlace, kMostFinalists);
  if (candidates.empty()) return candidates;
  for (Candidate& twin : Twins(candidates.front())) candidates.push_back(std::move(twin));
  SortByScore(candidates);
  candidates = Distinct(candidates, kSamePlace, kMostFinalists);
  candidates.front() = Simplest(candidates.front());
  SortByScore(candidates);
  return candidates;
}

void Aligner::RefineAll(std::vector<Candidate>& candidates, const RefineOptions& options) const {
  ForEachIndex(candidates.size(), options_.threads, [&](std::size_t i) {
    if (IsStopped(options_)) return;
    candidates[i].transform = Refine(faces_, evidence_, candidates[i].transform, options);
    Judge(candidates[i]);
  });
  SortByScore(candidates);
}

void Aligner::Judge(Candidate& candidate) const {
  candidate.agreement = Compare(FaceIndex(Transformed(faces_, candidate.transform), kJudgedReach), evidence_);
  candidate.score = ScoreOf(candidate.agreement);
}

Candidate Aligner::BestModel(const Candidate& start, double widest) const {
  Candidate best = start;
  if (options_.known_shape) return OfKnownShape(start, widest);
  for (const TransformModel model :
       {TransformModel::kSimilarity, TransformModel::kAnisotropic, TransformModel::kAffine}) {
    if (FreedomOf(model) > FreedomOf(options_.widest_model) || IsStopped(options_)) break;
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

Candidate Aligner::OfKnownShape(const Candidate& start, double widest) const {
  Candidate held = start;
  held.transform = Refine(faces_, evidence_, start.transform, {.model = TransformModel::kRigid, .widest = widest});
  Judge(held);
  Candidate scaled = held;
  scaled.transform = Refine(faces_, evidence_, held.transform, {.model = TransformModel::kSimilarity, .widest = 1.0});
  Judge(scaled);
  const double growth = scaled.transform.scale() / options_.known_shape->scale();
  return std::abs(growth - 1) <= kKnownScale && scaled.score > held.score ? scaled : held;
}

Candidate Aligner::RefinedFrom(Candidate start, double within) const {
  Judge(start);
  const Candidate refined = BestModel(start, within);
  return refined.score >= start.score ? refined : start;
}

// The place without its distortion, if that explains the map nearly as well.
Candidate Aligner::Simplest(const Candidate& candidate) const {
  if (candidate.model == TransformModel::kSimilarity || options_.known_shape) return candidate;
  Candidate simple{.transform = AsSimilarity(candidate.transform, map_centre()), .agreement = {}};
  simple = BestModel(simple, 1.5);
  return 1 - candidate.score < options_.most_left * (1 - simple.score) ? candidate : simple;
}

std::vector<Candidate> Aligner::Distinct(const std::vector<Candidate>& sorted, double apart, std::size_t most) const {
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

bool Aligner::IsOpenAlongWalls(const PlanTransform& transform) const {
  const FaceIndex index(Transformed(faces_, transform), kJudgedReach);
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (const WallPoint& wall : evidence_.walls) {
    if (wall.straightness < kStraight) continue;
    const auto nearest = index.Nearest(wall.point, wall.along, kParallel);
    if (nearest && nearest->distance <= kExplainedDistance) sum += wall.along * wall.along.transpose();
  }
  const Eigen::Vector2d lengths = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(sum).eigenvalues();
  return lengths(0) < kOneDirection * lengths(1);
}

Eigen::Vector2d Aligner::map_centre() const {
  const Eigen::Vector2d size(evidence_.geometry.width, evidence_.geometry.height);
  return evidence_.geometry.T_map_grid * (0.5 * evidence_.geometry.resolution * size);
}

double Aligner::search_radius() const {
  return 0.5 * evidence_.geometry.resolution * std::hypot(evidence_.geometry.width, evidence_.geometry.height);
}

}  // namespace enfilade::prior
