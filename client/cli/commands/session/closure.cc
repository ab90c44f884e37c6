// SPDX-License-Identifier: Apache-2.0
#include <functional>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sdk/api/paging.h"
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

std::string LoopClosureStateName(v1::Closure::State state) {
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
          {"state", LoopClosureStateName(closure.state())},
          {"score", closure.score()},
          {"chi2", closure.chi2()},
          {"reason", closure.reason()}};
}

std::vector<std::string> ToRow(const v1::Closure& closure) {
  return {IdOf(closure.name()),
          LoopClosureStateName(closure.state()),
          std::to_string(closure.submap()),
          std::to_string(closure.node()),
          fmt::format("{:.2f}", closure.score()),
          fmt::format("{:.2f}", closure.chi2()),
          closure.reason()};
}

absl::Status ListLoopClosures(const Globals& globals, const LoopClosureCommandOptions& options) {
  v1::ListClosuresRequest request;
  request.set_parent(ResourceNameOf(globals, "sessions", options.session));
  request.set_page_size(client::kMaxPageSize);
  ENFILADE_ASSIGN_OR_RETURN(std::vector<v1::Closure> closures,
                            client::ListAll(ConnectionOf(globals), &v1::SessionService::Stub::ListClosures, request,
                                            &v1::ListClosuresResponse::closures));
  if (!options.all) {
    std::erase_if(closures, [](const v1::Closure& c) { return c.state() == v1::Closure::STATE_REJECTED; });
  }
  PrintList<v1::Closure>(globals, closures, {"CLOSURE", "STATE", "SUBMAP", "NODE", "SCORE", "CHI2", "REASON"}, ToJson,
                         ToRow);
  return absl::OkStatus();
}

template <typename Request, typename Response>
absl::Status ChangeLoopClosure(const Globals& globals, const LoopClosureCommandOptions& options,
                               grpc::Status (v1::SessionService::Stub::*method)(grpc::ClientContext*, const Request&,
                                                                                Response*)) {
  Request request;
  request.set_name(
      fmt::format("{}/closures/{}", ResourceNameOf(globals, "sessions", options.session), options.closure));
  ENFILADE_ASSIGN_OR_RETURN(const Response response, ConnectionOf(globals).Call(method, request));
  if (globals.json) {
    PrintJson(std::cout, ToJson(response.closure()));
  } else {
    std::cout << response.closure().name() << " is " << LoopClosureStateName(response.closure().state())
              << "; the server maps the session again\n";
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
  CLI::App* list = AddCommand(*closure, "list", "List a session's loop closures",
                              [&globals, options] { return ListLoopClosures(globals, *options); });
  list->add_option("SESSION", options->session, "The session's id or resource name")->required();
  list->add_flag("--all", options->all, "Also those that mapping rejected, with the reason");
  list->footer("Example: enfilade closure list 5d0c... --all");
  AddChange(*closure, "suspend", "Leave one out of the map", options, [&globals, options] {
    return ChangeLoopClosure(globals, *options, &v1::SessionService::Stub::SuspendClosure);
  });
  AddChange(*closure, "resume", "Use a suspended one again", options, [&globals, options] {
    return ChangeLoopClosure(globals, *options, &v1::SessionService::Stub::ResumeClosure);
  });
}

}  // namespace enfilade::cli
