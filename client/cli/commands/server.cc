// SPDX-License-Identifier: Apache-2.0
#include <iostream>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/server_service.grpc.pb.h"

namespace enfilade::cli {
namespace {

absl::Status PrintStatus(const Globals& globals) {
  ENFILADE_ASSIGN_OR_RETURN(
      const v1::GetServerStatusResponse status,
      ConnectionOf(globals).Call(&v1::ServerService::Stub::GetServerStatus, v1::GetServerStatusRequest()));
  if (globals.json) {
    PrintJson(std::cout, {{"server", globals.server},
                          {"version", status.version()},
                          {"uptime_s", status.uptime().seconds()},
                          {"ready", status.ready()},
                          {"not_ready_reason", status.not_ready_reason()},
                          {"schema_version", status.schema_version()},
                          {"expected_schema_version", status.expected_schema_version()},
                          {"sessions_mapping", status.sessions_mapping()},
                          {"streams_open", status.streams_open()},
                          {"warnings", std::vector<std::string>(status.warnings().begin(), status.warnings().end())}});
  } else {
    std::cout << "enfilade-server " << status.version() << " at " << globals.server << ", up "
              << FormatSeconds(static_cast<double>(status.uptime().seconds())) << '\n'
              << (status.ready() ? "ready" : "NOT READY: " + status.not_ready_reason()) << '\n'
              << "schema " << status.schema_version() << ", " << status.streams_open() << " streams open, "
              << status.sessions_mapping() << " sessions being mapped\n";
    for (const std::string& warning : status.warnings()) std::cout << "warning: " << warning << '\n';
  }
  return status.ready() ? absl::OkStatus() : absl::UnavailableError("the server is not ready");
}

}  // namespace

void AddServer(CLI::App& app, const Globals& globals) {
  CLI::App* server = app.add_subcommand("server", "The server");
  server->require_subcommand(1);
  CLI::App* status = AddCommand(*server, "status", "Show version, readiness and load; exit code 4 if it is not ready",
                                [&globals] { return PrintStatus(globals); });
  status->footer("Example: enfilade --server robots.example:50051 server status");
}

}  // namespace enfilade::cli
