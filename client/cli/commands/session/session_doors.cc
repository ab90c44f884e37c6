// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/session/session_doors.h"

#include <iostream>
#include <memory>

#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/session_service.grpc.pb.h"

namespace enfilade::cli {
namespace {

// "candidate made", "link point recognised", ...
std::string DecisionInWords(v1::DoorVerdict::Decision decision) {
  std::string name = v1::DoorVerdict::Decision_Name(decision);
  const std::string prefix = "DECISION_";
  if (name.rfind(prefix, 0) == 0) name = name.substr(prefix.size());
  for (char& c : name) c = c == '_' ? ' ' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name;
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
          {"decision", DecisionInWords(verdict.decision())},
          {"link_point", verdict.link_point()},
          {"entered_map", verdict.entered_map()},
          {"pose_map_robot", verdict.has_pose_map_robot() ? PoseToJson(verdict.pose_map_robot()) : nlohmann::json()},
          {"comparisons", std::move(comparisons)},
          {"reason", verdict.reason()},
          {"graph_version", verdict.graph_version()},
          {"create_time", TimeInWords(verdict.create_time())}};
}

std::string IdOrDash(const std::string& name) { return name.empty() ? "-" : IdOf(name); }

absl::Status ListDoors(const Globals& globals, const std::string& session) {
  const client::Connection connection = ConnectionOf(globals);
  nlohmann::json documents = nlohmann::json::array();
  std::vector<std::vector<std::string>> rows;
  v1::ListDoorVerdictsRequest request;
  request.set_parent(SessionNameOf(globals, session));
  do {
    ENFILADE_ASSIGN_OR_RETURN(const v1::ListDoorVerdictsResponse page,
                              connection.Call(&v1::SessionService::Stub::ListDoorVerdicts, request));
    for (const v1::DoorVerdict& verdict : page.verdicts()) {
      documents.push_back(ToJson(verdict));
      rows.push_back({IdOf(verdict.name()), DecisionInWords(verdict.decision()), IdOrDash(verdict.link_point()),
                      IdOrDash(verdict.entered_map()), std::to_string(verdict.comparisons_size()), verdict.reason()});
    }
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty());
  if (globals.json) {
    PrintJson(std::cout, documents);
  } else {
    PrintTable(std::cout, {"RECORD", "DECISION", "LINK POINT", "ENTERED MAP", "COMPARED", "REASON"}, rows);
  }
  return absl::OkStatus();
}

}  // namespace

void AddSessionDoors(CLI::App& session, const Globals& globals) {
  auto id = std::make_shared<std::string>();
  CLI::App* doors = AddCommand(session, "doors", "What was made of its door reports, with the comparisons (--json)",
                               [&globals, id] { return ListDoors(globals, *id); });
  doors->add_option("SESSION", *id, "Its id or resource name")->required();
  doors->footer("Example: enfilade session doors 5d0c... --json");
}

}  // namespace enfilade::cli
