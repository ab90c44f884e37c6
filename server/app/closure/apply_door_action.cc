// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/apply_door_action.h"

#include <optional>
#include <utility>
#include <variant>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/app/closure/evidence_keeper.h"

namespace enfilade::server {
namespace {

// Adds an action to the change of its report.
class DoorChangeBuilder {
 public:
  DoorChangeBuilder(const DoorClosureStores& stores, const SiteId& site, const JudgedReport& judged,
                    storage::DoorChange& change)
      : stores_(stores), site_(site), judged_(judged), change_(change) {}

  absl::Status operator()(const closure::LeaveUnjudged& action) {
    if (action.map) change_.new_map = ToNewMap(*action.map, judged_.knowledge.options);
    return absl::OkStatus();
  }
  absl::Status operator()(const closure::KeepKnownCandidate& /*action*/) { return absl::OkStatus(); }
  absl::Status operator()(const closure::MakeCandidate& action) {
    MakeLinkPoint(action.candidate, std::nullopt);
    Keeper().KeepSighting(action.candidate.id);
    return absl::OkStatus();
  }
  absl::Status operator()(const closure::RecogniseLinkPoint& /*action*/) { return absl::OkStatus(); }
  absl::Status operator()(const closure::JoinLinkPoint& action) {
    ENFILADE_ASSIGN_OR_RETURN(storage::StoredLinkPoint stored, Get(action.link_point));
    stored.point.anchors.push_back(action.anchor);
    change_.link_point = std::move(stored);
    Keeper().KeepBeforeDoor(action.link_point);
    return absl::OkStatus();
  }
  absl::Status operator()(const closure::PromoteCandidate& action) {
    ENFILADE_ASSIGN_OR_RETURN(storage::StoredLinkPoint stored, Get(action.link_point));
    stored.point.anchors = action.anchors;
    stored.point.direction = action.entered.map;
    stored.point.kind = action.kind;
    change_.link_point = std::move(stored);
    Keeper().KeepBeforeDoor(action.link_point);
    return absl::OkStatus();
  }
  absl::Status operator()(const closure::LinkKnownMaps& action) {
    Link(action.link_point, std::nullopt);
    return absl::OkStatus();
  }
  absl::Status operator()(const closure::StartMap& action) {
    change_.new_map = ToNewMap(action.map, judged_.knowledge.options);
    Link(action.link_point, action.map.environment);
    return absl::OkStatus();
  }
  absl::Status operator()(const closure::WaitForMapping& /*action*/) {
    return Internal("waiting is not an action to be carried out");
  }

 private:
  EvidenceKeeper Keeper() { return {judged_.knowledge, *judged_.scene, change_}; }
  absl::StatusOr<storage::StoredLinkPoint> Get(const LinkPointId& id) const {
    return stores_.link_points.Get(JudgingLease::Context(), site_, id);
  }
  void MakeLinkPoint(const graph::LinkPoint& link_point, const std::optional<Environment>& environment) {
    storage::StoredLinkPoint made;
    made.site = site_;
    made.point = link_point;
    made.environment = environment;
    change_.new_link_point = std::move(made);
  }
  // With evidence from both sides of the door.
  void Link(const graph::LinkPoint& link_point, const std::optional<Environment>& environment) {
    MakeLinkPoint(link_point, environment);
    Keeper().KeepBeforeDoor(link_point.id);
    Keeper().KeepBehindDoor(link_point.id, *link_point.FindAnchor(link_point.direction));
  }

  const DoorClosureStores& stores_;
  const SiteId& site_;
  const JudgedReport& judged_;
  storage::DoorChange& change_;
};

}  // namespace

storage::NewMap ToNewMap(const closure::MapToStart& map, const closure::DoorClosureOptions& options) {
  return {.id = map.id,
          .name_prefix = options.map_name,
          .level = map.level,
          .environment = map.environment,
          .slam_profile = map.slam_profile};
}

absl::StatusOr<closure::DoorVerdict> ApplyDoorAction(const DoorClosureStores& stores, const JudgingLease& lease,
                                                     const JudgedReport& judged) {
  storage::DoorChange change;
  change.verdict = closure::ToVerdict(judged.judgement);
  change.verdict.session = judged.session;
  change.verdict.sequence = judged.sequence;
  change.verdict.graph_version = judged.knowledge.graph->version();
  change.verdict.T_odom_robot = judged.T_odom_robot;
  change.verdict.evidence = judged.compared_records;
  change.consumed = judged.judgement.used_up;
  ENFILADE_RETURN_IF_ERROR(
      std::visit(DoorChangeBuilder(stores, lease.site(), judged, change), judged.judgement.action));
  ENFILADE_RETURN_IF_ERROR(stores.verdicts.Commit(JudgingLease::Context(), lease.lease(), change));
  return std::move(change.verdict);
}

}  // namespace enfilade::server
