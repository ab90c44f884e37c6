// SPDX-License-Identifier: Apache-2.0
#include "core/closure/door_action.h"

namespace enfilade::closure {
namespace {

// Writes an action's part of the verdict.
struct VerdictWriter {
  DoorVerdict& verdict;

  void Write(DoorDecision decision, const LinkPointId& link_point) const {
    verdict.decision = decision;
    verdict.link_point = link_point;
  }
  void Write(DoorDecision decision, const LinkPointId& link_point, const EnteredMap& entered) const {
    Write(decision, link_point);
    verdict.entered_map = entered.map;
    verdict.T_map_robot = entered.T_map_robot;
  }

  void operator()(const LeaveUnjudged& action) const {
    verdict.decision = DoorDecision::kNotJudged;
    if (action.map) verdict.entered_map = action.map->id;
  }
  void operator()(const KeepKnownCandidate& action) const { Write(DoorDecision::kCandidateKnown, action.link_point); }
  void operator()(const MakeCandidate& action) const { Write(DoorDecision::kCandidateMade, action.candidate.id); }
  void operator()(const RecogniseLinkPoint& action) const {
    Write(DoorDecision::kLinkPointRecognised, action.link_point, action.entered);
  }
  void operator()(const JoinLinkPoint& action) const {
    Write(DoorDecision::kLinkPointRecognised, action.link_point, action.entered);
  }
  void operator()(const PromoteCandidate& action) const {
    Write(DoorDecision::kCandidatePromoted, action.link_point, action.entered);
  }
  void operator()(const LinkKnownMaps& action) const {
    Write(DoorDecision::kLinkPointMade, action.link_point.id, action.entered);
  }
  void operator()(const StartMap& action) const {
    Write(DoorDecision::kLinkPointMade, action.link_point.id, action.entered);
  }
  void operator()(const WaitForMapping& /*action*/) const {}
};

}  // namespace

MapToStart DescribeNewMap(const MapId& id, const SessionMap* from, const sensor::DoorReport* report,
                          const DoorClosureOptions& options) {
  MapToStart map;
  map.id = id;
  if (from != nullptr) {
    map.level = from->level;
    map.environment = from->environment;
  }
  if (report != nullptr && report->entered_level) map.level = *report->entered_level;
  if (report != nullptr && report->entered_environment) map.environment = *report->entered_environment;
  map.slam_profile = map.environment == Environment::kOutdoor ? options.outdoor_profile : options.indoor_profile;
  return map;
}

DoorVerdict ToVerdict(const DoorJudgement& judgement) {
  DoorVerdict verdict;
  std::visit(VerdictWriter{verdict}, judgement.action);
  verdict.comparisons = judgement.comparisons;
  verdict.reason = judgement.reason;
  return verdict;
}

const char* NameOf(DoorDecision decision) {
  switch (decision) {
    case DoorDecision::kCandidateMade:
      return "candidate made";
    case DoorDecision::kCandidateKnown:
      return "candidate known";
    case DoorDecision::kCandidatePromoted:
      return "candidate promoted";
    case DoorDecision::kLinkPointRecognised:
      return "link point recognised";
    case DoorDecision::kLinkPointMade:
      return "link point made";
    case DoorDecision::kNotJudged:
      return "not judged";
  }
  return "?";
}

const LinkPointId* FindChangedLinkPoint(const DoorAction& action) {
  if (const auto* join = std::get_if<JoinLinkPoint>(&action)) return &join->link_point;
  if (const auto* promote = std::get_if<PromoteCandidate>(&action)) return &promote->link_point;
  return nullptr;
}

}  // namespace enfilade::closure
