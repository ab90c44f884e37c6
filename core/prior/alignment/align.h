// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/prior/alignment/agreement.h"
#include "core/prior/alignment/control_pairs.h"
#include "core/prior/alignment/map_evidence.h"
#include "core/prior/alignment/plan_transform.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

// Where a plan lies in a map, before it is corrected wall by wall.
struct Alignment {
  bool accepted = false;
  std::string reason;  // why it is not, or what it rests on
  PlanTransform T_map_sheet;
  TransformModel model = TransformModel::kSimilarity;
  Agreement agreement;
  // How much better it fits than the best other place; 0: no other was compared (people showed the place).
  double rival_ratio = 0;
  // nats by which it is likelier than the likeliest of the other places that were judged by evidence; 0: none was.
  double log_odds = 0;
};

struct AlignOptions {
  // What has to hold of an alignment that nobody has shown (see AlignByItself).
  double least_explained = 0.35;
  double most_contradicted = 0.25;
  double least_rival_ratio = 1.3;
  // ... if it explains less than a sure place. Right places of robots' maps were contradicted by up to 10 %, plans of
  // other floors and buildings by 12 % and more.
  double most_contradicted_unsure = 0.12;
  // A place that explains so much, and is contradicted by so little, need not be so much better than any other.
  double sure_explained = 0.6;
  double sure_contradicted = 0.1;
  double sure_rival_ratio = 1.15;
  double least_length = 25;  // m of the map's walls that the plan explains
  double mirror_gain = 1.1;  // a mirrored plan must fit so much better than any that is not
  // How likely the map's walls are when the plan is corrected at a place (CorrectedPlan::log_evidence), nats. It
  // decides between a few places that fit nearly alike; null: none of these is accepted. Several threads call it.
  double (*log_evidence)(const PlanGraph& plan, const MapEvidence& evidence, const PlanTransform& place) = nullptr;
  // How a building may lie over itself: straight, turned by half, and turned over along or across.
  std::size_t most_twins = 4;
  // The likeliest must be 100 times as likely as the next. Evidence counts each metre of a wall for itself, but a
  // wall's metres tell alike, and walls have about four: 4 ln(100).
  double least_evidence = 18.4;
  double mirror_evidence = 2.2;  // and more, if it is mirrored and the next is not: one plan of ten is, ln(9)
  // Of a known shape a place that fits so much better than any other must be ten times as likely, too: 4 ln(10).
  double confirming_evidence = 9.2;
  // The distortions to try.
  TransformModel widest_model = TransformModel::kAffine;
  // A distortion is taken if it leaves at most this share of what the simpler one leaves unexplained.
  double most_left = 0.9;
  // Only places like this one: its size within kKnownScale, its stretch, and mirrored if it is.
  std::optional<PlanTransform> known_shape = std::nullopt;
  // Only scales (m per unit) from the first to the second.
  std::optional<std::pair<double, double>> known_scales = std::nullopt;
  // Asked now and then, on any thread. Once it is true, work ends soon and what comes out means nothing.
  std::function<bool()> is_stopped = nullptr;
  // What is independent is computed on so many threads. The result is the same with any number.
  int threads = 1;
};

inline bool IsStopped(const AlignOptions& options) { return options.is_stopped && options.is_stopped(); }

constexpr double kKnownScale = 0.03;

// By points that people have shown. The plan is then moved onto the map's walls, as far as the clicks may be wrong.
// Where the pairs fit it turned over, too, the walls decide whether it is mirrored. Accepted, whatever the walls say;
// the reason says so if they are all parallel, as in a bare corridor, along which the plan lies where the clicks put
// it.
absl::StatusOr<Alignment> AlignByPairs(const PlanGraph& plan, const MapEvidence& evidence,
                                       const std::vector<ControlPair>& pairs, const AlignOptions& options);

// Without any help: all turns that bring the directions of walls together, all scales, all offsets, straight and
// mirrored (SheetSearch); the best are refined (Refine) and compared. The best place is accepted if it explains enough
// of the map's walls, is contradicted by little of what the map knows, and fits so much better than any other place. If
// none is accepted, shapes whose axes have different scales are tried, which must meet the limits of a sure place. If a
// few places fit nearly alike, and all others worse, the one at which the corrected plan is much the likeliest is
// taken. Maps that are aligned by a known shape are small, and fit at many places: of these the best one must also be
// the likeliest.
Alignment AlignByItself(const PlanGraph& plan, const MapEvidence& evidence, const AlignOptions& options);

// From a place that is about right: the plan is moved onto the map's walls. Accepted if it explains enough and is
// contradicted by little, as AlignByItself; no other place is compared.
Alignment AlignFrom(const PlanGraph& plan, const MapEvidence& evidence, const PlanTransform& start,
                    const AlignOptions& options);

}  // namespace enfilade::prior
