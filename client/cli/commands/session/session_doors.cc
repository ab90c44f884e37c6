// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sdk/api/paging.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/session_service.grpc.pb.h"

namespace enfilade::cli {
namespace {

// "candidate made", "link point recognised", ...
std::string DecisionName(v1::DoorVerdict::Decision decision) {
  return EnumText(v1::DoorVerdict::Decision_Name(decision), "DECISION_");
}

nlohmann::json ToJson(const v1::DoorComparison& comparison) {
  return {{"link_point", comparison.link_point()},
          {"map", comparison.map()},
          {"distance_m", comparison.distance_m()},
          {"image_matches", comparison.image_matches()},
          {"images_agree", comparison.images_agree()},
          {"registration_rmse_m", comparison.registration_rmse_m()},
          {"registration_inlier_share", comparison.registration_inlier_share()},
          {"clouds_agree", comparison.clouds_agree()},
          {"chi2", comparison.chi2()},
          {"accepted", comparison.accepted()},
          {"reason", comparison.reason()}};
}

nlohmann::json ToJson(const v1::DoorVerdict& verdict) {
  nlohmann::json comparisons = nlohmann::json::array();
  for (const v1::DoorComparison& comparison : verdict.comparisons()) comparisons.push_back(ToJson(comparison));
  return {{"name", verdict.name()},
          {"decision", DecisionName(verdict.decision())},
          {"link_point", verdict.link_point()},
          {"entered_map", verdict.entered_map()},
          {"pose_map_robot", verdict.has_pose_map_robot() ? PoseToJson(verdict.pose_map_robot()) : nlohmann::json()},
          {"comparisons", std::move(comparisons)},
          {"reason", verdict.reason()},
          {"graph_version", verdict.graph_version()},
          {"create_time", FormatTime(verdict.create_time())}};
}

std::vector<std::string> ToRow(const v1::DoorVerdict& verdict) {
  return {IdOf(verdict.name()),        DecisionName(verdict.decision()),           IdOf(verdict.link_point()),
          IdOf(verdict.entered_map()), std::to_string(verdict.comparisons_size()), verdict.reason()};
}

absl::Status ListDoors(const Globals& globals, const std::string& session) {
  v1::ListDoorVerdictsRequest request;
  request.set_parent(ResourceNameOf(globals, "sessions", session));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<v1::DoorVerdict> verdicts,
                            client::ListAll(ConnectionOf(globals), &v1::SessionService::Stub::ListDoorVerdicts, request,
                                            &v1::ListDoorVerdictsResponse::verdicts));
  PrintList<v1::DoorVerdict>(globals, verdicts,
                             {"RECORD", "DECISION", "LINK POINT", "ENTERED MAP", "COMPARED", "REASON"}, ToJson, ToRow);
  return absl::OkStatus();
}

}  // namespace

void AddSessionDoors(CLI::App& session, const Globals& globals) {
  auto id = std::make_shared<std::string>();
  CLI::App* doors =
      AddCommand(session, "doors", "Show what the server decided about its door reports (--json: with comparisons)",
                 [&globals, id] { return ListDoors(globals, *id); });
  doors->add_option("SESSION", *id, "Its id or resource name")->required();
  doors->footer("Example: enfilade session doors 5d0c... --json");
}

}  // namespace enfilade::cli
