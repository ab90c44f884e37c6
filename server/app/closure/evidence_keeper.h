// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>

#include "core/closure/door_knowledge.h"
#include "server/app/closure/session_scene.h"
#include "storage/graph/door_verdict_store.h"

namespace enfilade::server {

// Adds what the session saw of a door to a change, as evidence for the anchors of its link point: up to images_kept
// images of each camera, and the nearest cloud. The records' sequences are added to the verdict.
class EvidenceKeeper {
 public:
  // All must outlive it.
  EvidenceKeeper(const closure::DoorKnowledge& knowledge, const SessionScene& scene, storage::DoorChange& change)
      : knowledge_(knowledge), scene_(scene), change_(change) {}

  // Of a candidate, around the time when the robot saw the door.
  void KeepSighting(const LinkPointId& candidate);
  // Of a passage, before the door: for the anchor in the session's map.
  void KeepBeforeDoor(const LinkPointId& link_point);
  // Of a passage, behind the door: for the anchor in the entered map.
  void KeepBehindDoor(const LinkPointId& link_point, const graph::Anchor& there);

 private:
  // Where the robot was in the anchor's map.
  using PoseAt = std::function<std::optional<Pose2>(TimeNs)>;

  void Keep(const LinkPointId& link_point, const MapId& map, const ViewWindow& window, const PoseAt& T_map_robot);
  std::optional<Pose2> SessionPoseAt(TimeNs time) const;

  const closure::DoorKnowledge& knowledge_;
  const SessionScene& scene_;
  storage::DoorChange& change_;
};

// Of a candidate: the time around which its evidence was recorded.
ViewWindow SightingWindow(const closure::DoorKnowledge& knowledge);

}  // namespace enfilade::server
