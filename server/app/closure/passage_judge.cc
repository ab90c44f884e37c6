// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/passage_judge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/status_macros.h"
#include "core/closure/joined_anchors.h"
#include "core/closure/known_places.h"
#include "core/graph/global_pose.h"
#include "core/graph/paths/pose_chain.h"
#include "core/graph/search_radius.h"
#include "server/app/closure/arrival.h"
#include "server/app/closure/passage_location.h"

namespace enfilade::server {
namespace {

// What the robot saw between the door and its report: of what lies behind.
absl::StatusOr<ViewsBehind> LookBehind(const storage::CallContext& context, const PassageScene& passage,
                                       StoredViews& views, std::vector<std::int64_t>& seen) {
  const sensor::DoorReport& report = passage.report;
  ViewsBehind behind;
  const TimeNs late = report.time + DurationOf(0.5);
  const bool judged_before = passage.waited > 0.0;
  for (const sensor::Camera camera : {sensor::Camera::kFront, sensor::Camera::kRear}) {
    for (const auto& image :
         passage.scene.ImagesNear(camera, report.time, report.door_time, late, passage.options.images_now)) {
      ENFILADE_ASSIGN_OR_RETURN(const auto* features, views.Features(context, image.image.content, judged_before));
      seen.push_back(image.sequence);
      if (features == nullptr) continue;
      (camera == sensor::Camera::kFront ? behind.ahead : behind.back).push_back(features);
    }
    if (!behind.ahead.empty()) break;  // the rear camera is only for robots without
  }
  const auto cloud = passage.scene.CloudNear(report.time, report.door_time, late);
  if (!cloud) return behind;
  const auto T_map_cloud = passage.scene.PoseAt(cloud->cloud.time);
  if (!T_map_cloud) return behind;
  seen.push_back(cloud->sequence);
  ENFILADE_ASSIGN_OR_RETURN(behind.cloud, views.Points(context, cloud->cloud.content, cloud->cloud.encoding));
  behind.T_cloud_robot = Between(T_map_cloud->pose, passage.T_map_robot.pose);
  behind.beyond = (T_map_cloud->pose.translation() - passage.T_map_door.pose.translation()).norm();
  return behind;
}

// The evidence of one anchor.
std::vector<storage::Evidence> Of(const std::vector<storage::Evidence>& all, const LinkPointId& link_point,
                                  const MapId& map) {
  std::vector<storage::Evidence> found;
  std::copy_if(all.begin(), all.end(), std::back_inserter(found),
               [&](const storage::Evidence& item) { return item.link_point == link_point && item.map == map; });
  return found;
}

bool IsOnLevel(const PassageScene& passage, const MapId& map) {
  const graph::MapInGraph* found = passage.graph.graph().FindMap(map);
  return found != nullptr && found->level == passage.report.entered_level.value_or(passage.map.level);
}

// The map behind a link point of this map: the one on the level that was entered, the latest made where there are more.
const graph::Anchor* FindBehind(const PassageScene& passage, const graph::LinkPoint& link_point) {
  const graph::Anchor* behind = nullptr;
  for (const graph::Anchor& anchor : link_point.anchors) {
    if (anchor.map == passage.map.id) continue;
    if (behind == nullptr || IsOnLevel(passage, anchor.map)) behind = &anchor;
  }
  return behind;
}

// A link point of this very map. True where it is one.
absl::StatusOr<bool> TryPassed(const storage::CallContext& context, const PassageScene& passage,
                               const std::vector<closure::KnownPlace>& passed, const ViewsBehind& behind,
                               StoredViews& views, storage::DoorChange& change, std::set<LinkPointId>& contradicted) {
  for (const closure::KnownPlace& known : passed) {
    if (known.link_point->is_candidate()) continue;
    const graph::Anchor* anchor = FindBehind(passage, *known.link_point);
    if (anchor == nullptr) continue;
    ENFILADE_RETURN_IF_ERROR(passage.go_on());
    const auto T_map_robot = closure::PoseBehind(*known.link_point, passage.map.id, anchor->map, passage.T_map_robot);
    ENFILADE_ASSIGN_OR_RETURN(
        auto evidence, passage.stores.link_points.ListEvidence(context, passage.map.site, {known.link_point->id}));
    const Place place{.link_point = known.link_point,
                      .anchor = anchor,
                      .evidence = Of(evidence, known.link_point->id, anchor->map),
                      .distance = known.distance,
                      .predicted = T_map_robot};
    ENFILADE_ASSIGN_OR_RETURN(closure::PlaceEvidence compared,
                              CompareImages(context, place, behind, passage.options, views));
    // The images agree and the pose is right: clouds would add nothing.
    if (!compared.images || !compared.images->agree) {
      ENFILADE_RETURN_IF_ERROR(CompareClouds(context, place, behind, passage.options, views, compared));
    }
    const closure::JudgedPlace judged = closure::JudgePlace(compared, passage.options);
    closure::DoorComparison comparison = closure::ToComparison(compared, judged);
    const bool refused = closure::Contradicted(compared, passage.options);
    comparison.accepted = !refused;
    comparison.chi2 = known.chi2;
    comparison.reason =
        known.reason + (refused ? "; but what the robot sees contradicts it: " : "; ") + judged.witnesses;
    change.verdict.comparisons.push_back(comparison);
    if (refused) {
      contradicted.insert(known.link_point->id);
      continue;
    }
    Recognise(*known.link_point, anchor->map, *T_map_robot, change.verdict.comparisons.back().reason, change.verdict);
    return true;
  }
  return false;
}

// Places of other maps that the robot may have come to: within the search radius, or where no link points lead there.
// Those that are in reach first, the nearest first.
absl::StatusOr<std::vector<Place>> FindPlaces(const storage::CallContext& context, const PassageScene& passage,
                                              const graph::TransformsTo& to_this,
                                              const std::set<LinkPointId>& not_these) {
  const graph::GraphSnapshot& graph = passage.graph.graph();
  std::map<MapId, std::optional<PoseWithCovariance>> transforms;  // T_other_this
  std::vector<Place> places;
  for (const graph::LinkPoint* link_point : graph.ListLinkPoints()) {
    if (link_point->use == graph::LinkPointUse::kSuspended || not_these.contains(link_point->id)) continue;
    if (link_point->is_candidate() && passage.excluded.contains(link_point->id)) continue;
    for (const graph::Anchor& anchor : link_point->anchors) {
      if (anchor.map == passage.map.id || !IsOnLevel(passage, anchor.map)) continue;
      auto [found, is_new] = transforms.try_emplace(anchor.map);
      if (is_new) {
        ENFILADE_ASSIGN_OR_RETURN(const auto transform, to_this.Find(anchor.map));
        if (transform) found->second = transform->T_a_b;
      }
      Place place{.link_point = link_point, .anchor = &anchor, .evidence = {}, .distance = {}, .predicted = {}};
      if (found->second) {
        const PoseWithCovariance door = Compose(*found->second, passage.T_map_door);
        place.predicted = Compose(*found->second, passage.T_map_robot);
        place.distance = (door.pose.translation() - anchor.T_map_place.translation()).norm();
        const double radius = graph::SearchRadius(door.covariance + anchor.covariance,
                                                  {passage.options.search_base, passage.options.search_factor});
        if (*place.distance > radius) continue;
      }
      places.push_back(std::move(place));
    }
  }
  std::stable_sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
    constexpr double kNowhere = std::numeric_limits<double>::infinity();
    return a.distance.value_or(kNowhere) < b.distance.value_or(kNowhere);
  });
  const auto limit = static_cast<std::size_t>(passage.options.max_compared);
  if (places.size() > limit) places.resize(limit);
  std::vector<LinkPointId> ids;
  for (const Place& place : places) ids.push_back(place.link_point->id);
  ENFILADE_ASSIGN_OR_RETURN(const auto evidence,
                            passage.stores.link_points.ListEvidence(context, passage.map.site, ids));
  for (Place& place : places) place.evidence = Of(evidence, place.link_point->id, place.anchor->map);
  return places;
}

absl::StatusOr<std::vector<closure::PlaceEvidence>> ComparePlaces(const storage::CallContext& context,
                                                                  const PassageScene& passage,
                                                                  const std::vector<Place>& places,
                                                                  const ViewsBehind& behind, StoredViews& views) {
  std::vector<closure::PlaceEvidence> compared;
  for (const Place& place : places) {
    ENFILADE_RETURN_IF_ERROR(passage.go_on());
    ENFILADE_ASSIGN_OR_RETURN(compared.emplace_back(), CompareImages(context, place, behind, passage.options, views));
  }
  // Registration is dear: for those with the best images, then those that images tell nothing of, or that the graph has
  // at this very door; the nearest of equals.
  std::vector<std::size_t> order(places.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto rank = [&](std::size_t i) {
    const closure::PlaceEvidence& evidence = compared[i];
    return evidence.images && evidence.images->agree ? evidence.images->matches : 0;
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return rank(a) > rank(b); });
  const auto is_worth_it = [&](const closure::PlaceEvidence& evidence) {
    if (!evidence.images || evidence.images->agree) return true;
    if (!evidence.predicted || !evidence.distance) return false;
    return *evidence.distance <=
           passage.options.known_ahead + graph::ErrorEllipse95(evidence.predicted->covariance).semi_major_m;
  };
  int registered = 0;
  for (const std::size_t i : order) {
    if (registered >= passage.options.max_registered) break;
    if (!is_worth_it(compared[i])) continue;
    ENFILADE_RETURN_IF_ERROR(passage.go_on());
    ENFILADE_RETURN_IF_ERROR(CompareClouds(context, places[i], behind, passage.options, views, compared[i]));
    if (compared[i].clouds) ++registered;
  }
  return compared;
}

// Of the places that have the robot where the chosen one has it, the one whose door it came by; else the chosen one.
std::size_t FindDoor(const PassageScene& passage, const std::vector<Place>& places,
                     const closure::PassageChoice& choice) {
  const closure::JudgedPlace& chosen = choice.judged[*choice.chosen];
  const MapId& there = places[*choice.chosen].anchor->map;
  for (const std::size_t i : choice.order) {
    const closure::JudgedPlace& judged = choice.judged[i];
    if (!judged.accepted || places[i].anchor->map != there) continue;
    const Pose2 d = Between(judged.T_map_robot.pose, chosen.T_map_robot.pose);
    if (d.translation().norm() > passage.options.same_pose) continue;
    const graph::Anchor door =
        closure::JoinAtDoor(passage.map.id, passage.T_map_robot.pose, passage.T_map_door, there, judged.T_map_robot)
            .there;
    if (closure::IsDoorOf(*places[i].link_point, *places[i].anchor, {door.T_map_place, door.covariance},
                          passage.options)) {
      return i;
    }
  }
  return *choice.chosen;
}

}  // namespace

absl::StatusOr<std::string> JudgePassage(const storage::CallContext& context, const PassageScene& passage,
                                         StoredViews& views, storage::DoorChange& change) {
  const std::vector<closure::KnownPlace> passed =
      closure::FindPassed(passage.graph.graph().ListLinkPoints(), passage.map.id, passage.T_map_door, passage.options);
  ENFILADE_ASSIGN_OR_RETURN(const ViewsBehind behind, LookBehind(context, passage, views, change.verdict.evidence));
  std::set<LinkPointId> contradicted;
  ENFILADE_ASSIGN_OR_RETURN(const bool known, TryPassed(context, passage, passed, behind, views, change, contradicted));
  if (known) return "";

  ENFILADE_ASSIGN_OR_RETURN(const graph::TransformsTo to_this,
                            graph::TransformsTo::Make(passage.graph.graph(), passage.map.id));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<Place> places, FindPlaces(context, passage, to_this, contradicted));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<closure::PlaceEvidence> compared,
                            ComparePlaces(context, passage, places, behind, views));
  const closure::PassageChoice choice = closure::ChoosePlace(compared, passage.options);
  for (const std::size_t i : choice.order) {
    change.verdict.comparisons.push_back(closure::ToComparison(compared[i], choice.judged[i]));
  }
  // The same door, seen from this side before.
  std::vector<LinkPointId> own;
  for (const closure::KnownPlace& place : passed) {
    if (place.link_point->is_candidate()) own.push_back(place.link_point->id);
  }
  if (choice.chosen) {
    const std::size_t arrived = FindDoor(passage, places, choice);
    const closure::JudgedPlace& judged = choice.judged[arrived];
    ENFILADE_RETURN_IF_ERROR(Arrive(
        context, passage, {places[arrived].anchor->map, places[arrived].link_point, judged.T_map_robot, judged.reason},
        own, change));
    return "";
  }
  // Look-alikes that images and clouds could not tell apart are none for scans either.
  PassageLocation location;
  if (!choice.ambiguous) {
    ENFILADE_ASSIGN_OR_RETURN(location, LocatePassage(context, passage, to_this, compared));
  }
  if (location.found) {
    ENFILADE_RETURN_IF_ERROR(Arrive(context, passage, *location.found, own, change));
  } else if (location.wait_for.empty()) {
    Begin(passage, own, choice.reason + location.reason, change);
  }
  return location.wait_for;
}

}  // namespace enfilade::server
