// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/session/closure.h"

#include <iostream>
#include <memory>

#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/session_service.grpc.pb.h"

namespace enfilade::cli {
namespace {

struct LoopClosureCommandOptions {
  std::string session;
  std::int64_t closure = 0;
  bool all = false;
};

std::string LoopClosureStateInWords(v1::Closure::State state) {
  switch (state) {
    case v1::Closure::STATE_ACCEPTED:
      return "accepted";
    case v1::Closure::STATE_REJECTED:
      return "rejected";
    case v1::Closure::STATE_SUSPENDED:
      return "suspended";
    default:
      return "?";
  }
}

nlohmann::json ToJson(const v1::Closure& closure) {
  const v1::Pose2& pose = closure.pose_submap_node();
  return {{"name", closure.name()},
          {"submap", closure.submap()},
          {"node", closure.node()},
          {"pose_submap_node", {pose.x(), pose.y(), pose.yaw()}},
          {"state", LoopClosureStateInWords(closure.state())},
          {"score", closure.score()},
          {"chi2", closure.chi2()},
          {"reason", closure.reason()}};
}

absl::Status ListClosures(const Globals& globals, const LoopClosureCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  nlohmann::json documents = nlohmann::json::array();
  std::vector<std::vector<std::string>> rows;
  v1::ListClosuresRequest request;
  request.set_parent(SessionNameOf(globals, options.session));
  request.set_page_size(1000);
  do {
    ENFILADE_ASSIGN_OR_RETURN(const v1::ListClosuresResponse page,
                              connection.Call(&v1::SessionService::Stub::ListClosures, request));
    for (const v1::Closure& closure : page.closures()) {
      if (!options.all && closure.state() == v1::Closure::STATE_REJECTED) continue;
      documents.push_back(ToJson(closure));
      rows.push_back({IdOf(closure.name()), LoopClosureStateInWords(closure.state()), std::to_string(closure.submap()),
                      std::to_string(closure.node()), fmt::format("{:.2f}", closure.score()),
                      fmt::format("{:.2f}", closure.chi2()), closure.reason()});
    }
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty());
  if (globals.json) {
    PrintJson(std::cout, documents);
  } else {
    PrintTable(std::cout, {"CLOSURE", "STATE", "SUBMAP", "NODE", "SCORE", "CHI2", "REASON"}, rows);
  }
  return absl::OkStatus();
}

template <typename Request, typename Response>
absl::Status ChangeLoopClosures(const Globals& globals, const LoopClosureCommandOptions& options,
                                grpc::Status (v1::SessionService::Stub::*method)(grpc::ClientContext*, const Request&,
                                                                                 Response*)) {
  Request request;
  request.set_name(fmt::format("{}/closures/{}", SessionNameOf(globals, options.session), options.closure));
  ENFILADE_ASSIGN_OR_RETURN(const Response response, ConnectionOf(globals).Call(method, request));
  if (globals.json) {
    PrintJson(std::cout, ToJson(response.closure()));
  } else {
    std::cout << response.closure().name() << " is " << LoopClosureStateInWords(response.closure().state())
              << "; the session's map is made anew\n";
  }
  return absl::OkStatus();
}

void AddChange(CLI::App& closure, const std::string& name, const std::string& description,
               const std::shared_ptr<LoopClosureCommandOptions>& options, std::function<absl::Status()> run) {
  CLI::App* command = AddCommand(closure, name, description, std::move(run));
  command->add_option("SESSION", options->session, "The session's id or resource name")->required();
  command->add_option("CLOSURE", options->closure, "The closure's number")->required();
  command->footer("Example: enfilade closure " + name + " 5d0c... 17");
}

}  // namespace

void AddLoopClosure(CLI::App& app, const Globals& globals) {
  CLI::App* closure = app.add_subcommand("closure", "Loop closures of a session's map");
  closure->require_subcommand(1);
  auto options = std::make_shared<LoopClosureCommandOptions>();
  CLI::App* list =
      AddCommand(*closure, "list", "List them", [&globals, options] { return ListClosures(globals, *options); });
  list->add_option("SESSION", options->session, "The session's id or resource name")->required();
  list->add_flag("--all", options->all, "Also those that mapping has rejected, with the reason");
  list->footer("Example: enfilade closure list 5d0c... --all");
  AddChange(*closure, "suspend", "Take one out of the map", options, [&globals, options] {
    return ChangeLoopClosures(globals, *options, &v1::SessionService::Stub::SuspendClosure);
  });
  AddChange(*closure, "resume", "Let one count again", options, [&globals, options] {
    return ChangeLoopClosures(globals, *options, &v1::SessionService::Stub::ResumeClosure);
  });
}

}  // namespace enfilade::cli
