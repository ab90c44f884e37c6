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

// "RECORDING", "FINISHED", ...
std::string SessionStateName(v1::Session::State state) {
  const std::string name = v1::Session::State_Name(state);
  const std::string prefix = "STATE_";
  return name.rfind(prefix, 0) == 0 ? name.substr(prefix.size()) : name;
}

nlohmann::json ToJson(const v1::Session& session) {
  const v1::RecordCounts& records = session.record_counts();
  const v1::MappingCounts& mapping = session.mapping_counts();
  return {{"name", session.name()},
          {"robot", session.robot()},
          {"map", session.map()},
          {"state", SessionStateName(session.state())},
          {"acknowledged_sequence", session.acknowledged_sequence()},
          {"mapped_sequence", session.mapped_sequence()},
          {"records",
           {{"laser_scans", records.laser_scans()},
            {"odometries", records.odometries()},
            {"images", records.images()},
            {"point_clouds", records.point_clouds()},
            {"withheld", records.withheld()},
            {"door_reports", records.door_reports()}}},
          {"mapping",
           {{"paired", mapping.paired()},
            {"unpaired", mapping.unpaired()},
            {"time_reversed", mapping.time_reversed()},
            {"used", mapping.used()},
            {"keyframes", mapping.keyframes()},
            {"lost", mapping.lost()}}},
          {"error", session.error()},
          {"create_time", FormatTime(session.create_time())},
          {"finish_time", FormatTime(session.finish_time())}};
}

std::vector<std::string> ToRow(const v1::Session& session) {
  return {IdOf(session.name()),
          IdOf(session.robot()),
          IdOf(session.map()),
          SessionStateName(session.state()),
          std::to_string(session.acknowledged_sequence()),
          std::to_string(session.mapped_sequence()),
          FormatTime(session.create_time())};
}

absl::Status ListSessions(const Globals& globals) {
  v1::ListSessionsRequest request;
  request.set_parent(SiteNameOf(globals));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<v1::Session> sessions,
                            client::ListAll(ConnectionOf(globals), &v1::SessionService::Stub::ListSessions, request,
                                            &v1::ListSessionsResponse::sessions));
  PrintList<v1::Session>(globals, sessions, {"SESSION", "ROBOT", "MAP", "STATE", "RECORDS", "MAPPED", "CREATED (UTC)"},
                         ToJson, ToRow);
  return absl::OkStatus();
}

absl::Status ShowSession(const Globals& globals, const std::string& id) {
  v1::GetSessionRequest request;
  request.set_name(ResourceNameOf(globals, "sessions", id));
  ENFILADE_ASSIGN_OR_RETURN(const v1::GetSessionResponse response,
                            ConnectionOf(globals).Call(&v1::SessionService::Stub::GetSession, request));
  const v1::Session& session = response.session();
  if (globals.json) {
    PrintJson(std::cout, ToJson(session));
    return absl::OkStatus();
  }
  const v1::RecordCounts& records = session.record_counts();
  const v1::MappingCounts& mapping = session.mapping_counts();
  std::cout << session.name() << "  " << SessionStateName(session.state()) << '\n'
            << "robot    " << session.robot() << '\n'
            << "map      " << (session.map().empty() ? "(only recorded)" : session.map()) << '\n'
            << "records  " << session.acknowledged_sequence() << " acknowledged: " << records.laser_scans()
            << " scans, " << records.odometries() << " odometries, " << records.images() << " images, "
            << records.point_clouds() << " clouds, " << records.withheld() << " withheld\n"
            << "mapped   " << session.mapped_sequence() << ": " << mapping.used() << " scans used, "
            << mapping.keyframes() << " keyframes, " << mapping.lost() << " lost; " << mapping.paired() << " paired, "
            << mapping.unpaired() << " without odometry, " << mapping.time_reversed()
            << " with times going backwards\n";
  if (!session.error().empty()) std::cout << "error    " << session.error() << '\n';
  return absl::OkStatus();
}

}  // namespace

void AddSession(CLI::App& app, const Globals& globals) {
  CLI::App* session = app.add_subcommand("session", "Sessions: what robots have recorded");
  session->require_subcommand(1);
  AddCommand(*session, "list", "List the site's sessions, the newest first",
             [&globals] { return ListSessions(globals); });
  auto id = std::make_shared<std::string>();
  CLI::App* show =
      AddCommand(*session, "show", "Show one session", [&globals, id] { return ShowSession(globals, *id); });
  show->add_option("SESSION", *id, "Its id or resource name")->required();
  show->footer("Example: enfilade session show 5d0c... --json");
  AddSessionDoors(*session, globals);
}

}  // namespace enfilade::cli
