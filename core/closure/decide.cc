// SPDX-License-Identifier: Apache-2.0
#include "core/closure/decide.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>

#include "core/closure/choose_map_by_scans.h"
#include "core/closure/enter_map.h"
#include "core/closure/joined_anchors.h"
#include "core/closure/judge_place.h"
#include "core/closure/known_places.h"
#include "core/graph/search_radius.h"

namespace enfilade::closure {
namespace {

DoorJudgement NotJudged(const DoorKnowledge& knowledge, std::string reason) {
  LeaveUnjudged action;
  if (knowledge.report.kind == sensor::DoorReport::Kind::kPassage) {
    const SessionMap* from = knowledge.map ? &*knowledge.map : nullptr;
    action.map = DescribeNewMap(knowledge.new_map, from, &knowledge.report, knowledge.options);
    reason += "; a new map starts that no link point joins";
  }
  return {.action = std::move(action), .reason = std::move(reason)};
}

DoorJudgement JudgeCandidate(const DoorKnowledge& knowledge) {
  const std::vector<KnownPlace> known = FindSighted(knowledge.graph->ListLinkPointsIn(knowledge.map->id),
                                                    knowledge.map->id, *knowledge.T_map_door, knowledge.options);
  if (!known.empty()) {
    return {.action = KeepKnownCandidate{known.front().link_point->id}, .reason = known.front().reason};
  }
  graph::LinkPoint candidate;
  candidate.id = knowledge.new_link_point;
  candidate.kind = knowledge.report.place;
  candidate.anchors = {{knowledge.map->id, knowledge.T_map_door->pose, knowledge.T_map_door->covariance}};
  return {.action = MakeCandidate{std::move(candidate)},
          .reason = knowledge.has_views ? "no place is known there"
                                        : "no place is known there; neither images nor clouds were recorded near it"};
}

bool HaveImagesAgreed(const PlaceEvidence& evidence) { return evidence.images && evidence.images->agree; }

// A link point of the session's own map. Appends a comparison for each one that is contradicted; unset: all are.
std::optional<DoorStep> TryPassedLinkPoints(const DoorKnowledge& knowledge, std::vector<DoorComparison>& comparisons) {
  const std::vector<PassedLinkPoint>& passed = knowledge.passed->link_points;
  for (std::size_t i = 0; i < passed.size(); ++i) {
    const ComparedPlace& place = passed[i].place;
    const PlaceIndex index{.passed = true, .index = i};
    if (!place.images_compared) return CompareImages{{index}};
    // Where the images agree and the pose is right, clouds would add nothing.
    if (!place.clouds_compared && !HaveImagesAgreed(place.evidence)) return CompareClouds{index};
    const JudgedPlace judged = JudgePlace(place.evidence, knowledge.options);
    const bool contradicted = IsContradicted(place.evidence, knowledge.options);
    DoorComparison comparison = ToComparison(place.evidence, judged);
    comparison.accepted = !contradicted;
    comparison.chi2 = passed[i].known.chi2;
    comparison.reason =
        passed[i].known.reason + (contradicted ? "; but what the robot sees contradicts it: " : "; ") + judged.compared;
    comparisons.push_back(std::move(comparison));
    if (contradicted) continue;
    return DoorJudgement{
        .action = RecogniseLinkPoint{place.link_point->id, {place.anchor->map, place.evidence.predicted}},
        .reason = comparisons.back().reason,
        .comparisons = comparisons};
  }
  return std::nullopt;
}

// Registration is expensive: only places that images cannot judge or that they favour are worth it, and those that the
// graph has at this very door.
bool IsWorthRegistering(const PlaceEvidence& evidence, const DoorClosureOptions& options) {
  if (!evidence.images || evidence.images->agree) return true;
  if (!evidence.predicted || !evidence.distance) return false;
  return *evidence.distance <= options.known_ahead + graph::ErrorEllipse95(evidence.predicted->covariance).semi_major_m;
}

// The comparison of the places that is missing; unset: none. Clouds are compared in the order of the images' matches,
// and of equals the nearest place first.
std::optional<DoorStep> ComparePlaces(const DoorKnowledge& knowledge) {
  const std::vector<ComparedPlace>& places = *knowledge.places;
  CompareImages images;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!places[i].images_compared) images.places.push_back({.passed = false, .index = i});
  }
  if (!images.places.empty()) return images;
  std::vector<std::size_t> order(places.size());
  std::iota(order.begin(), order.end(), 0);
  const auto rank = [&](std::size_t i) {
    return HaveImagesAgreed(places[i].evidence) ? places[i].evidence.images->matches : 0;
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return rank(a) > rank(b); });
  int registered = 0;
  for (const std::size_t i : order) {
    if (registered >= knowledge.options.max_registered) break;
    if (!IsWorthRegistering(places[i].evidence, knowledge.options)) continue;
    if (!places[i].clouds_compared) return CompareClouds{{.passed = false, .index = i}};
    if (places[i].evidence.clouds) ++registered;
  }
  return std::nullopt;
}

// Of the places that have the robot where the chosen one has it, the one whose door it passed; else the chosen one.
std::size_t FindPassedPlace(const DoorKnowledge& knowledge, const PassageChoice& choice) {
  const std::vector<ComparedPlace>& places = *knowledge.places;
  const JudgedPlace& chosen = choice.judged[*choice.chosen];
  const MapId& there = places[*choice.chosen].anchor->map;
  for (const std::size_t i : choice.order) {
    const JudgedPlace& judged = choice.judged[i];
    if (!judged.accepted || places[i].anchor->map != there) continue;
    const Pose2 d = Between(judged.T_map_robot.pose, chosen.T_map_robot.pose);
    if (d.translation().norm() > knowledge.options.same_pose) continue;
    const graph::Anchor door =
        JoinAtDoor(knowledge.map->id, knowledge.T_map_robot->pose, *knowledge.T_map_door, there, judged.T_map_robot)
            .there;
    if (IsDoorOf(*places[i].link_point, *places[i].anchor, {door.T_map_place, door.covariance}, knowledge.options)) {
      return i;
    }
  }
  return *choice.chosen;
}

DoorStep JudgeByScans(const DoorKnowledge& knowledge, const std::vector<PlaceEvidence>& compared,
                      const PassageChoice& choice) {
  // Scans cannot tell look-alikes apart that images and clouds could not.
  if (choice.ambiguous || knowledge.points_behind_door.empty()) return StartNewMap(knowledge, choice.reason);
  if (!knowledge.maps) return SearchGraph{SearchGraph::Target::kMaps};
  for (std::size_t i = 0; i < knowledge.maps->size(); ++i) {
    if (!(*knowledge.maps)[i].scans) return MatchScans{i};
  }
  ScanSearchResult result = ChooseMapByScans(knowledge, compared);
  if (!result.wait_for.empty()) return DoorJudgement{.action = WaitForMapping{std::move(result.wait_for)}};
  if (result.found) return EnterKnownMap(knowledge, *result.found);
  return StartNewMap(knowledge, choice.reason + result.reason);
}

DoorStep JudgePassage(const DoorKnowledge& knowledge) {
  if (!knowledge.passed) return SearchGraph{SearchGraph::Target::kPassedDoor};
  std::vector<DoorComparison> comparisons;
  if (auto step = TryPassedLinkPoints(knowledge, comparisons)) return *std::move(step);
  if (!knowledge.places) return SearchGraph{SearchGraph::Target::kPlaces};
  if (auto step = ComparePlaces(knowledge)) return *std::move(step);

  std::vector<PlaceEvidence> compared;
  for (const ComparedPlace& place : *knowledge.places) compared.push_back(place.evidence);
  const PassageChoice choice = ChoosePlace(compared, knowledge.options);
  for (const std::size_t i : choice.order) comparisons.push_back(ToComparison(compared[i], choice.judged[i]));
  DoorStep step;
  if (choice.chosen) {
    const std::size_t i = FindPassedPlace(knowledge, choice);
    const ComparedPlace& place = (*knowledge.places)[i];
    const JudgedPlace& judged = choice.judged[i];
    step = EnterKnownMap(knowledge, {place.anchor->map, place.link_point, judged.T_map_robot, judged.reason});
  } else {
    step = JudgeByScans(knowledge, compared, choice);
  }
  if (auto* judgement = std::get_if<DoorJudgement>(&step)) judgement->comparisons = std::move(comparisons);
  return step;
}

}  // namespace

DoorStep Decide(const DoorKnowledge& knowledge) {
  if (!knowledge.map) return NotJudged(knowledge, "the session was only recorded");
  if (knowledge.mapping_error || !knowledge.T_map_door || !knowledge.T_map_robot) {
    std::string reason = knowledge.mapping_error ? "mapping failed: " + *knowledge.mapping_error
                                                 : "nothing was mapped when the robot was at the door";
    if (knowledge.by_odometry) return JoinByOdometry(knowledge, std::move(reason));
    return NotJudged(knowledge, std::move(reason));
  }
  if (knowledge.report.kind == sensor::DoorReport::Kind::kCandidate) return JudgeCandidate(knowledge);
  return JudgePassage(knowledge);
}

}  // namespace enfilade::closure
