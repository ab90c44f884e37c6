// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/door_evidence.h"

#include <iterator>
#include <utility>

namespace enfilade::server {
namespace {

std::optional<Pose2> PoseOf(const std::optional<PoseWithCovariance>& pose) {
  return pose ? std::optional<Pose2>(pose->pose) : std::nullopt;
}

}  // namespace

std::vector<storage::Evidence> EvidenceAt(const SessionScene& scene, const LinkPointId& link_point, const MapId& map,
                                          TimeNs time, TimeNs from, TimeNs to,
                                          const std::function<std::optional<Pose2>(TimeNs)>& T_map_robot,
                                          const closure::DoorClosureOptions& options, std::vector<std::int64_t>& seen) {
  std::vector<storage::Evidence> evidence;
  const auto add = [&](std::int64_t sequence, storage::EvidenceKind kind, std::int16_t encoding,
                       const sensor::BlobRef& content, TimeNs recorded) {
    evidence.push_back({link_point, map, kind, encoding, content, recorded, T_map_robot(recorded)});
    seen.push_back(sequence);
  };
  for (const sensor::Camera camera : {sensor::Camera::kFront, sensor::Camera::kRear}) {
    const storage::EvidenceKind kind =
        camera == sensor::Camera::kFront ? storage::EvidenceKind::kFrontImage : storage::EvidenceKind::kRearImage;
    for (const auto& image : scene.ImagesNear(camera, time, from, to, options.images_kept)) {
      add(image.sequence, kind, static_cast<std::int16_t>(image.image.encoding), image.image.content, image.image.time);
    }
  }
  if (const auto cloud = scene.CloudNear(time, from, to)) {
    add(cloud->sequence, storage::EvidenceKind::kCloud, static_cast<std::int16_t>(cloud->cloud.encoding),
        cloud->cloud.content, cloud->cloud.time);
  }
  return evidence;
}

void KeepEvidenceHere(const PassageScene& passage, const LinkPointId& link_point, storage::DoorChange& change) {
  const sensor::DoorReport& report = passage.report;
  const SessionScene& scene = passage.scene;
  // Where the robot was when it had the door before it, as a candidate is seen.
  TimeNs before = report.door_time;
  for (TimeNs time = report.door_time; time > report.door_time - DurationOf(10.0); time -= DurationOf(0.25)) {
    const auto pose = scene.PoseAt(time);
    if (!pose) break;
    before = time;
    if ((pose->pose.translation() - passage.T_map_door.pose.translation()).norm() >= passage.options.latch_distance) {
      break;
    }
  }
  const TimeNs window = DurationOf(passage.options.image_window);
  auto evidence = EvidenceAt(
      scene, link_point, passage.map.id, before, before - window, report.door_time,
      [&scene](TimeNs time) { return PoseOf(scene.PoseAt(time)); }, passage.options, change.verdict.evidence);
  std::move(evidence.begin(), evidence.end(), std::back_inserter(change.evidence));
}

void KeepEvidenceBehind(const PassageScene& passage, const LinkPointId& link_point, const graph::Anchor& there,
                        storage::DoorChange& change) {
  const SessionScene& scene = passage.scene;
  const Pose2 T_there_here = there.T_map_place * Inverse(passage.T_map_door.pose);
  auto evidence = EvidenceAt(
      scene, link_point, there.map, passage.report.time, passage.report.door_time,
      passage.report.time + DurationOf(0.5),
      [&](TimeNs time) -> std::optional<Pose2> {
        const auto pose = scene.PoseAt(time);
        return pose ? std::optional<Pose2>(T_there_here * pose->pose) : std::nullopt;
      },
      passage.options, change.verdict.evidence);
  std::move(evidence.begin(), evidence.end(), std::back_inserter(change.evidence));
}

}  // namespace enfilade::server
