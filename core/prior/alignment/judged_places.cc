// SPDX-License-Identifier: Apache-2.0
#include "core/prior/alignment/judged_places.h"

#include <algorithm>

#include "core/base/parallel.h"

namespace enfilade::prior {

std::vector<JudgedPlace> JudgedByEvidence(const PlanGraph& plan, const MapEvidence& evidence,
                                          const std::vector<Candidate>& places, const AlignOptions& options) {
  std::vector<JudgedPlace> judged(places.size());
  ForEachIndex(places.size(), options.threads, [&](std::size_t i) {
    if (IsStopped(options)) return;
    judged[i] = {places[i], options.log_evidence(plan, evidence, places[i].transform)};
  });
  std::stable_sort(judged.begin(), judged.end(),
                   [](const JudgedPlace& a, const JudgedPlace& b) { return a.evidence > b.evidence; });
  return judged;
}

double NeededEvidence(const PlanTransform& likelier, const PlanTransform& other, const AlignOptions& options) {
  const bool is_odd = likelier.mirrored() && !other.mirrored() && !options.known_shape;
  return options.least_evidence + (is_odd ? options.mirror_evidence : 0);
}

}  // namespace enfilade::prior
