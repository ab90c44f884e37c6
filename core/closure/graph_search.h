// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/closure/decide.h"
#include "core/closure/door_knowledge.h"
#include "core/graph/global_pose.h"

namespace enfilade::closure {

// Searches the graph for what a passage may have led to. Predictions chain poses from the session's map to others: one
// search over the graph serves all of them, made when it is first needed.
class GraphSearch {
 public:
  // Sets the part of the knowledge that `step` asks for. Pass the same knowledge, or a copy, in all calls of
  // one object. NOT_FOUND: the graph does not have the session's map.
  absl::Status Run(const SearchGraph& step, DoorKnowledge& knowledge);

 private:
  absl::StatusOr<graph::TransformsTo*> TransformsToSessionMap(const DoorKnowledge& knowledge);
  absl::StatusOr<std::vector<ComparedPlace>> FindPlaces(const DoorKnowledge& knowledge);
  absl::StatusOr<std::vector<SearchedMap>> FindMaps(const DoorKnowledge& knowledge);

  std::optional<graph::TransformsTo> transforms_;
};

// The link points of the session's map that lie where the door was passed, with the place on their other side (on the
// entered level, if there is one), and the candidates that were made when this door was seen.
PassedDoor FindPassedDoor(const DoorKnowledge& knowledge);

}  // namespace enfilade::closure
