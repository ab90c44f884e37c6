// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "server/app/closure/passage_scene.h"

namespace enfilade::server {

// What the session saw from `map` at `time`, as evidence for an anchor: up to images_kept images of each camera and the
// nearest cloud, all within [from, to]. Adds the records to `seen`.
std::vector<storage::Evidence> EvidenceAt(const SessionScene& scene, const LinkPointId& link_point, const MapId& map,
                                          TimeNs time, TimeNs from, TimeNs to,
                                          const std::function<std::optional<Pose2>(TimeNs)>& T_map_robot,
                                          const closure::DoorClosureOptions& options, std::vector<std::int64_t>& seen);

// What the session saw before the door, for the anchor in its own map, goes into `change` ...
void KeepEvidenceHere(const PassageScene& passage, const LinkPointId& link_point, storage::DoorChange& change);
// ... and after it, for the anchor in the map behind.
void KeepEvidenceBehind(const PassageScene& passage, const LinkPointId& link_point, const graph::Anchor& there,
                        storage::DoorChange& change);

}  // namespace enfilade::server
