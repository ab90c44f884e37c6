// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "core/prior/alignment/agreement.h"
#include "core/prior/alignment/align.h"
#include "core/prior/alignment/map_evidence.h"
#include "core/prior/alignment/plan_shapes.h"
#include "core/prior/alignment/plan_transform.h"
#include "core/prior/alignment/refine.h"
#include "core/prior/alignment/wall_faces.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

// A place where a plan may lie.
struct Candidate {
  PlanTransform transform;
  TransformModel model = TransformModel::kSimilarity;
  double score = 0;
  Agreement agreement;
};

// How well a place fits: how near the map's walls are to the plan's, less what contradicts them.
double ScoreOf(const Agreement& agreement);

// Finds the places where a plan may lie in a map, and moves it onto the map's walls there. The evidence and the options
// outlive it.
class Aligner {
 public:
  Aligner(const PlanGraph& plan, const MapEvidence& evidence, const AlignOptions& options);

  // The best places of a search, refined; not sorted.
  std::vector<Candidate> Finalists(Stretch stretch) const;
  // The finalists of one search or several, the best first, each place once. The best is compared with its twins.
  std::vector<Candidate> Ranked(std::vector<Candidate> candidates) const;
  void Judge(Candidate& candidate) const;
  // The simplest model, from that of the start on, that explains the map nearly as well as any; if the shape is known,
  // that, of a size within kKnownScale.
  Candidate BestModel(const Candidate& start, double widest) const;
  // The same from a place that nobody has judged, and that may be `within` (m) of where the plan lies; the start itself
  // if that fits better.
  Candidate RefinedFrom(Candidate start, double within) const;
  // Whether both put what the map knows of the plan to the same place, within a metre, straight or mirrored.
  bool IsSamePlace(const PlanTransform& a, const PlanTransform& b) const;
  // Whether all walls that it explains are parallel: they do not tell where along them it lies.
  bool IsOpenAlongWalls(const PlanTransform& transform) const;

 private:
  double Apart(const PlanTransform& a, const PlanTransform& b) const;
  std::vector<Candidate> Search(Stretch stretch) const;
  std::vector<Candidate> Twins(const Candidate& candidate) const;
  void RefineAll(std::vector<Candidate>& candidates, const RefineOptions& options) const;
  Candidate OfKnownShape(const Candidate& start, double widest) const;
  Candidate Simplest(const Candidate& candidate) const;
  std::vector<Candidate> Distinct(const std::vector<Candidate>& sorted, double apart, std::size_t most) const;
  Eigen::Vector2d map_centre() const;
  double search_radius() const;

  std::vector<WallFace> faces_;
  std::vector<Eigen::Vector2d> corners_;
  const MapEvidence& evidence_;
  const AlignOptions& options_;
};

}  // namespace enfilade::prior
