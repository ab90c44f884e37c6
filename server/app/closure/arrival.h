// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "server/app/closure/passage_scene.h"

namespace enfilade::server {

// Where a robot that has gone through a door has come to.
struct Destination {
  MapId map;
  const graph::LinkPoint* link_point = nullptr;  // of `map`, that it may have come through; null: none is known there
  PoseWithCovariance T_map_robot;                // when it reports
  std::string reason;
};

// A link point that the graph has already.
void Recognise(const graph::LinkPoint& link_point, const MapId& map, const PoseWithCovariance& T_map_robot,
               std::string why, closure::DoorVerdict& verdict);

// Into a known map: its link point is recognised, joined to the session's map, or promoted; by a door that is new, a
// link point is made. `own`: candidates of the session's map that were sightings of this door. Errors are the stores'.
absl::Status Arrive(const storage::CallContext& context, const PassageScene& passage, const Destination& to,
                    const std::vector<LinkPointId>& own, storage::DoorChange& change);

// Nothing known: a link point, and a map that begins at it.
void Begin(const PassageScene& passage, const std::vector<LinkPointId>& own, std::string why,
           storage::DoorChange& change);

}  // namespace enfilade::server
