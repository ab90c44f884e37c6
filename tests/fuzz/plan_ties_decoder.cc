// SPDX-License-Identifier: Apache-2.0
// What ties maps to a plan, as it is stored.
#include "core/graph/plans/plan_ties.h"
#include "tests/fuzz/decoder.h"
#include "tests/support/plans/sample_ties.h"

namespace enfilade::fuzz {

std::vector<std::string> Seeds() {
  graph::PlanTies without_shafts = graph::SampleTies();
  without_shafts.shafts.clear();
  return {graph::EncodePlanTies({}), graph::EncodePlanTies(without_shafts), graph::EncodePlanTies(graph::SampleTies())};
}

bool Decode(std::string_view bytes) {
  const auto ties = graph::DecodePlanTies(bytes);
  if (!ties.ok()) {
    Expect(ties.status().code() == absl::StatusCode::kDataLoss ||
               ties.status().code() == absl::StatusCode::kFailedPrecondition,
           "damaged ties are refused as such");
    return false;
  }
  for (const graph::PlanStrut& strut : ties->struts) {
    const int count = static_cast<int>(ties->corners.size());
    Expect(strut.from >= 0 && strut.from < count && strut.to >= 0 && strut.to < count, "a strut has both its corners");
  }
  for (const graph::WallSighting& sighting : ties->sightings) {
    Expect(sighting.strut >= 0 && sighting.strut < static_cast<int>(ties->struts.size()), "a sighting has its strut");
    Expect(ties->HasSeen(sighting.map), "the map of a sighting is listed");
    Expect(IsFinite(sighting.T_map_line) && sighting.across_sigma > 0 && sighting.yaw_sigma > 0,
           "a sighting is a measurement");
  }
  for (const graph::ShaftInPlan& shaft : ties->shafts) {
    Expect(shaft.outline.size() >= 3 && shaft.held_by.size() == shaft.outline.size(), "a shaft is an area");
    for (const int corner : shaft.held_by) {
      Expect(corner >= 0 && corner < static_cast<int>(ties->corners.size()), "a corner holds it");
    }
  }
  Expect(graph::EncodePlanTies(*ties) == bytes, "ties are written as they were read");
  return true;
}

}  // namespace enfilade::fuzz
