// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/closure/judge_passage.h"
#include "core/graph/global_pose.h"
#include "server/app/closure/arrival.h"
#include "server/app/closure/passage_scene.h"

namespace enfilade::server {

// Is the robot in a map that is known, where no place that has images and clouds told of it: by another door, or one
// that only another robot has passed?
struct PassageLocation {
  std::optional<Destination> found;
  std::string wait_for;  // maps that others are in the middle of mapping and that may turn out to be the one
  std::string reason;    // why it is not found, to be added to another; may be empty
};

// Compares the scans behind the door with what robots have seen of each known map on the level that the graph has where
// the robot is (core/closure: LocateByScans). None where two maps would do, or where clouds or images of the very door
// speak against it (`compared`). `to_this`: the session's map. Errors are the stores'.
absl::StatusOr<PassageLocation> LocatePassage(const storage::CallContext& context, const PassageScene& passage,
                                              const graph::TransformsTo& to_this,
                                              const std::vector<closure::PlaceEvidence>& compared);

}  // namespace enfilade::server
