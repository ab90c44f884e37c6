// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/prior/alignment/align.h"
#include "core/prior/alignment/aligner.h"
#include "core/prior/alignment/map_evidence.h"
#include "core/prior/alignment/plan_transform.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

// A place where a plan may lie, and how likely the map is if it is corrected there.
struct JudgedPlace {
  Candidate place;
  double evidence = 0;  // nats, by AlignOptions::log_evidence
};

// The likeliest first. options.log_evidence is set.
std::vector<JudgedPlace> JudgedByEvidence(const PlanGraph& plan, const MapEvidence& evidence,
                                          const std::vector<Candidate>& places, const AlignOptions& options);

// nats by which the evidence of one place must exceed that of another for the other to be ruled out.
double NeededEvidence(const PlanTransform& likelier, const PlanTransform& other, const AlignOptions& options);

}  // namespace enfilade::prior
