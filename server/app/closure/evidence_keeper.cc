// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/evidence_keeper.h"

namespace enfilade::server {

ViewWindow SightingWindow(const closure::DoorKnowledge& knowledge) {
  const TimeNs time = knowledge.report.door_time;
  const TimeNs margin = DurationOf(knowledge.options.image_window);
  return {.time = time, .from = time - margin, .to = time + margin};
}

std::optional<Pose2> EvidenceKeeper::SessionPoseAt(TimeNs time) const {
  const auto pose = scene_.PoseAt(time);
  return pose ? std::optional<Pose2>(pose->pose) : std::nullopt;
}

void EvidenceKeeper::KeepSighting(const LinkPointId& candidate) {
  Keep(candidate, knowledge_.map->id, SightingWindow(knowledge_), [this](TimeNs time) { return SessionPoseAt(time); });
}

void EvidenceKeeper::KeepBeforeDoor(const LinkPointId& link_point) {
  const TimeNs door_time = knowledge_.report.door_time;
  // When the robot had the door ahead of it, as a candidate is seen.
  TimeNs before = door_time;
  for (TimeNs time = door_time; time > door_time - DurationOf(10.0); time -= DurationOf(0.25)) {
    const auto pose = scene_.PoseAt(time);
    if (!pose) break;
    before = time;
    const double distance = (pose->pose.translation() - knowledge_.T_map_door->pose.translation()).norm();
    if (distance >= knowledge_.options.latch_distance) break;
  }
  const ViewWindow window{
      .time = before, .from = before - DurationOf(knowledge_.options.image_window), .to = door_time};
  Keep(link_point, knowledge_.map->id, window, [this](TimeNs time) { return SessionPoseAt(time); });
}

void EvidenceKeeper::KeepBehindDoor(const LinkPointId& link_point, const graph::Anchor& there) {
  const sensor::DoorReport& report = knowledge_.report;
  const Pose2 T_there_here = there.T_map_place * Inverse(knowledge_.T_map_door->pose);
  const ViewWindow window{.time = report.time, .from = report.door_time, .to = report.time + DurationOf(0.5)};
  Keep(link_point, there.map, window, [&](TimeNs time) -> std::optional<Pose2> {
    const auto pose = scene_.PoseAt(time);
    return pose ? std::optional<Pose2>(T_there_here * pose->pose) : std::nullopt;
  });
}

void EvidenceKeeper::Keep(const LinkPointId& link_point, const MapId& map, const ViewWindow& window,
                          const PoseAt& T_map_robot) {
  const auto add = [&](std::int64_t sequence, storage::Evidence evidence) {
    evidence.link_point = link_point;
    evidence.map = map;
    evidence.T_map_robot = T_map_robot(evidence.time);
    change_.evidence.push_back(std::move(evidence));
    change_.verdict.evidence.push_back(sequence);
  };
  for (const sensor::Camera camera : {sensor::Camera::kFront, sensor::Camera::kRear}) {
    const storage::EvidenceKind kind =
        camera == sensor::Camera::kFront ? storage::EvidenceKind::kFrontImage : storage::EvidenceKind::kRearImage;
    for (const auto& seen : scene_.FindImages(camera, window, knowledge_.options.images_kept)) {
      add(seen.sequence, {.link_point = {},
                          .map = {},
                          .kind = kind,
                          .encoding = static_cast<std::int16_t>(seen.image.encoding),
                          .content = seen.image.content,
                          .time = seen.image.time});
    }
  }
  if (const auto seen = scene_.FindCloud(window)) {
    add(seen->sequence, {.link_point = {},
                         .map = {},
                         .kind = storage::EvidenceKind::kCloud,
                         .encoding = static_cast<std::int16_t>(seen->cloud.encoding),
                         .content = seen->cloud.content,
                         .time = seen->cloud.time});
  }
}

}  // namespace enfilade::server
