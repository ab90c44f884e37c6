// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/evidence_gatherer.h"

#include <algorithm>
#include <iterator>
#include <utility>
#include <variant>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/closure/scan_location.h"
#include "server/app/closure/known_scans.h"

namespace enfilade::server {
namespace {

// What the robot recorded between the door and its report shows what lies behind the door.
ViewWindow BehindDoorWindow(const sensor::DoorReport& report) {
  return {.time = report.time, .from = report.door_time, .to = report.time + DurationOf(0.5)};
}

}  // namespace

EvidenceGatherer::EvidenceGatherer(const DoorClosureStores& stores, const JudgingLease& lease,
                                   const SessionScene& scene, SeenGrounds& grounds, closure::DoorKnowledge& knowledge)
    : stores_(stores),
      lease_(lease),
      scene_(scene),
      grounds_(grounds),
      knowledge_(knowledge),
      views_(stores, lease, knowledge.options),
      comparer_(robot_, knowledge.options, views_) {}

absl::Status EvidenceGatherer::ReadRobotViews() {
  ENFILADE_RETURN_IF_ERROR(ReadRobotImages());
  return ReadRobotCloud();
}

absl::Status EvidenceGatherer::ReadRobotImages() {
  const bool was_judged_before = knowledge_.waited > 0.0;
  for (const sensor::Camera camera : {sensor::Camera::kFront, sensor::Camera::kRear}) {
    for (const auto& image :
         scene_.FindImages(camera, BehindDoorWindow(knowledge_.report), knowledge_.options.images_now)) {
      ENFILADE_ASSIGN_OR_RETURN(const auto* features, views_.Features(image.image.content, was_judged_before));
      used_records_.push_back(image.sequence);
      if (features == nullptr) continue;
      (camera == sensor::Camera::kFront ? robot_.ahead : robot_.back).push_back(features);
    }
    if (!robot_.ahead.empty()) break;  // the rear camera is for robots without a front camera
  }
  return absl::OkStatus();
}

absl::Status EvidenceGatherer::ReadRobotCloud() {
  const auto cloud = scene_.FindCloud(BehindDoorWindow(knowledge_.report));
  if (!cloud) return absl::OkStatus();
  const auto T_map_cloud = scene_.PoseAt(cloud->cloud.time);
  if (!T_map_cloud) return absl::OkStatus();
  used_records_.push_back(cloud->sequence);
  ENFILADE_ASSIGN_OR_RETURN(robot_.cloud, views_.Points(cloud->cloud.content, cloud->cloud.encoding));
  robot_.T_cloud_robot = Between(T_map_cloud->pose, knowledge_.T_map_robot->pose);
  robot_.beyond_door = (T_map_cloud->pose.translation() - knowledge_.T_map_door->pose.translation()).norm();
  return absl::OkStatus();
}

absl::Status EvidenceGatherer::Gather(const closure::DoorStep& step) {
  if (const auto* search = std::get_if<closure::SearchGraph>(&step)) return graph_search_.Run(*search, knowledge_);
  if (const auto* images = std::get_if<closure::CompareImages>(&step)) return Gather(*images);
  if (const auto* clouds = std::get_if<closure::CompareClouds>(&step)) return Gather(*clouds);
  if (const auto* scans = std::get_if<closure::MatchScans>(&step)) return Gather(*scans);
  return Internal("a judgement asks for no evidence");
}

absl::Status EvidenceGatherer::Gather(const closure::CompareImages& step) {
  std::vector<LinkPointId> ids;
  for (const closure::PlaceIndex& index : step.places) {
    ids.push_back(PlaceAt(knowledge_, index).link_point->id);
  }
  ENFILADE_ASSIGN_OR_RETURN(kept_, stores_.link_points.ListEvidence(JudgingLease::Context(), lease_.site(), ids));
  for (const closure::PlaceIndex& index : step.places) {
    ENFILADE_RETURN_IF_ERROR(lease_.Renew());
    closure::ComparedPlace& place = PlaceAt(knowledge_, index);
    ENFILADE_RETURN_IF_ERROR(comparer_.CompareImages(FindKept(place), place));
  }
  return absl::OkStatus();
}

absl::Status EvidenceGatherer::Gather(const closure::CompareClouds& step) {
  ENFILADE_RETURN_IF_ERROR(lease_.Renew());
  closure::ComparedPlace& place = PlaceAt(knowledge_, step.place);
  return comparer_.CompareClouds(FindKept(place), place);
}

absl::Status EvidenceGatherer::Gather(const closure::MatchScans& step) {
  ENFILADE_RETURN_IF_ERROR(lease_.Renew());
  closure::SearchedMap& searched = (*knowledge_.maps)[step.map];
  const KnownScansScope scope{.stores = stores_,
                              .site = lease_.site(),
                              .graph = *knowledge_.graph,
                              .options = knowledge_.options,
                              .grounds = grounds_};
  ENFILADE_ASSIGN_OR_RETURN(const KnownScans known, ReadKnownScans(scope, searched.map->id, searched.predicted));
  searched.scans = {.location = closure::LocateByScans(known.ground.get(), knowledge_.points_behind_door,
                                                       searched.predicted, knowledge_.options),
                    .recording = known.recording,
                    .mapping = known.mapping};
  return absl::OkStatus();
}

std::vector<storage::Evidence> EvidenceGatherer::FindKept(const closure::ComparedPlace& place) const {
  std::vector<storage::Evidence> found;
  std::copy_if(kept_.begin(), kept_.end(), std::back_inserter(found), [&](const storage::Evidence& item) {
    return item.link_point == place.link_point->id && item.map == place.anchor->map;
  });
  return found;
}

}  // namespace enfilade::server
