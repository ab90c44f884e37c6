// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/closure/decide.h"
#include "core/closure/graph_search.h"
#include "fmt/format.h"
#include "fmt/ranges.h"
#include "tests/support/status_assertions.h"

namespace enfilade::closure {

inline Eigen::Matrix3d SmallCovariance() { return Eigen::Vector3d(1e-4, 1e-4, 1e-4).asDiagonal(); }

inline PoseWithCovariance Sure(const Pose2& pose) { return {pose, SmallCovariance()}; }

// What there is to be found when Decide asks for it.
struct EvidenceBook {
  struct Views {
    std::optional<ImageComparison> images = {};
    std::optional<CloudComparison> clouds = {};
  };
  std::map<std::pair<std::string, std::string>, Views> views = {};  // by link point and map
  std::map<std::string, ScanEvidence> scans = {};                   // by map
};

struct DoorRun {
  DoorJudgement judgement;
  std::vector<std::string> steps;  // in the order in which they were asked for
  DoorKnowledge knowledge;
};

// A site of three maps on level 0 and one above. The robot's session is in `here`. It passes a door at (10, 0), looking
// east, and reports when it is at (12, 0). The frame of `room` is that door, as a link point "side" at (10, 8) of
// `here` and (0, 8) of `room` says; that of `hall` lies 30 m north of it, by a link point between room and hall.
class DoorScenario {
 public:
  DoorScenario() {
    AddMap("here", 0);
    AddMap("room", 0);
    AddMap("hall", 0);
    AddMap("attic", 1);
    Add("side", {{"here", {10, 8, 0}}, {"room", {0, 8, 0}}});
    Add("north", {{"room", {0, 30, 0}}, {"hall", {0, 0, 0}}});
    knowledge_.report.kind = sensor::DoorReport::Kind::kPassage;
    knowledge_.map = SessionMap{.id = MapId("here"), .level = 0, .environment = Environment::kIndoor};
    knowledge_.T_map_door = Sure({10, 0, 0});
    knowledge_.T_map_robot = Sure({12, 0, 0});
    knowledge_.T_door_robot = Sure({2, 0, 0});
    knowledge_.points_behind_door = {{1, 1}, {1, -1}};
    knowledge_.new_link_point = LinkPointId("new-point");
    knowledge_.new_map = MapId("new-map");
  }

  void AddMap(const std::string& id, int level) {
    changes_.maps.push_back({.id = MapId(id), .display_name = "The " + id, .level = level});
  }
  graph::LinkPoint& Add(const std::string& id, const std::vector<std::pair<std::string, Pose2>>& anchors) {
    graph::LinkPoint point;
    point.id = LinkPointId(id);
    for (const auto& [map, pose] : anchors) point.anchors.push_back({MapId(map), pose, SmallCovariance()});
    changes_.link_points.push_back(std::move(point));
    return changes_.link_points.back();
  }
  // Where a solution has the map. The world is the frame of `here`.
  void Solve(const std::string& map, const PoseWithCovariance& T_world_map) {
    if (changes_.solution == nullptr) {
      changes_.root = MapId("here");
      solution_.root = MapId("here");
      solution_.map_poses[solution_.root] = {};
    }
    solution_.map_poses[MapId(map)] = T_world_map;
    changes_.solution = std::make_shared<graph::SolvedGraph>(solution_);
  }
  // A door seen from (1.7, 0) of the room, looking west at the passed door.
  graph::LinkPoint& AddRoomCandidate(const std::string& id) { return Add(id, {{"room", {1.7, 0, M_PI}}}); }

  // Images and clouds have the robot at T_map_robot.
  void Agree(const std::string& id, const std::string& map, const Pose2& T_map_robot, int matches = 60) {
    book_.views[{id, map}] = {.images = ImageComparison{matches, true},
                              .clouds = CloudComparison{0.05, 0.9, true, Sure(T_map_robot)}};
  }
  void ShowNothing(const std::string& id, const std::string& map) {
    book_.views[{id, map}] = {.images = ImageComparison{2, false}, .clouds = CloudComparison{1.0, 0.2, false, {}}};
  }
  void LocateIn(const std::string& map, const Pose2& T_map_robot) {
    book_.scans[map].location = {
        .accepted = true, .T_map_robot = Sure(T_map_robot), .matched_share = 0.8, .reason = "80 % on walls"};
  }

  DoorKnowledge& knowledge() { return knowledge_; }
  EvidenceBook& book() { return book_; }

  // The knowledge with a snapshot of the graph as it is now.
  DoorKnowledge Knowledge() {
    auto snapshot = graph::Apply(graph::GraphSnapshot(), changes_);
    EXPECT_OK(snapshot.status());
    snapshot_ = *std::move(snapshot);
    DoorKnowledge knowledge = knowledge_;
    knowledge.graph = &snapshot_;
    return knowledge;
  }

  // Asks and answers until there is a judgement.
  DoorRun Run() { return RunFrom(Knowledge()); }
  DoorRun RunFrom(DoorKnowledge knowledge) const {
    DoorRun run{.judgement = {}, .steps = {}, .knowledge = std::move(knowledge)};
    GraphSearch search;
    for (int i = 0; i < 200; ++i) {
      const DoorStep step = Decide(run.knowledge);
      if (const auto* judgement = std::get_if<DoorJudgement>(&step)) {
        run.judgement = *judgement;
        return run;
      }
      run.steps.push_back(Answer(step, search, run.knowledge));
    }
    ADD_FAILURE() << "no judgement after " << fmt::format("{}", fmt::join(run.steps, " "));
    return run;
  }

 private:
  // Fills in what the step asks for; returns the step as text.
  std::string Answer(const DoorStep& step, GraphSearch& search, DoorKnowledge& knowledge) const {
    if (const auto* graph = std::get_if<SearchGraph>(&step)) {
      EXPECT_OK(search.Run(*graph, knowledge));
      switch (graph->target) {
        case SearchGraph::Target::kPassedDoor:
          return "graph:door";
        case SearchGraph::Target::kPlaces:
          return "graph:places";
        case SearchGraph::Target::kMaps:
          return "graph:maps";
      }
    }
    if (const auto* images = std::get_if<CompareImages>(&step)) {
      std::vector<std::string> names;
      for (const PlaceIndex& index : images->places) {
        ComparedPlace& place = PlaceAt(knowledge, index);
        place.evidence.images = ViewsOf(place).images;
        place.images_compared = true;
        names.push_back(place.link_point->id.value());
      }
      return fmt::format("images:{}", fmt::join(names, ","));
    }
    if (const auto* clouds = std::get_if<CompareClouds>(&step)) {
      ComparedPlace& place = PlaceAt(knowledge, clouds->place);
      place.evidence.clouds = ViewsOf(place).clouds;
      place.clouds_compared = true;
      return "clouds:" + place.link_point->id.value();
    }
    SearchedMap& searched = (*knowledge.maps)[std::get<MatchScans>(step).map];
    const auto found = book_.scans.find(searched.map->id.value());
    searched.scans = found == book_.scans.end() ? ScanEvidence{} : found->second;
    return "scans:" + searched.map->id.value();
  }

  EvidenceBook::Views ViewsOf(const ComparedPlace& place) const {
    const auto found = book_.views.find({place.link_point->id.value(), place.anchor->map.value()});
    return found == book_.views.end() ? EvidenceBook::Views{} : found->second;
  }

  graph::SnapshotChanges changes_;
  graph::SolvedGraph solution_;
  graph::GraphSnapshot snapshot_;
  DoorKnowledge knowledge_;
  EvidenceBook book_;
};

// The action, which must be of this type.
template <typename Action>
Action ActionOf(const DoorJudgement& judgement) {
  const auto* action = std::get_if<Action>(&judgement.action);
  EXPECT_NE(action, nullptr) << "action " << judgement.action.index() << ": " << judgement.reason;
  return action != nullptr ? *action : Action{};
}

}  // namespace enfilade::closure
