// SPDX-License-Identifier: Apache-2.0
#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <iostream>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/synchronization/mutex.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "io/file.h"
#include "server/app/runtime/logging.h"
#include "server/config/server_options.h"
#include "server/config/slam_profiles.h"
#include "server/server.h"
#include "server/version.h"
#include "spdlog/spdlog.h"

namespace {

using namespace enfilade;
using namespace enfilade::server;

struct CommandLine {
  std::string config;
  std::vector<std::string> settings;
  bool print_config = false;
};

absl::StatusOr<ServerOptions> LoadOptions(const CommandLine& command_line) {
  ServerOptions options;
  if (!command_line.config.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(const std::string text, io::ReadFile(command_line.config));
    ENFILADE_RETURN_IF_ERROR(ApplyYaml(text, command_line.config, options));
  }
  std::vector<std::string> environment;
  for (char** variable = environ; *variable; ++variable) environment.emplace_back(*variable);
  ENFILADE_RETURN_IF_ERROR(ApplyEnvironment(environment, options));
  for (const std::string& setting : command_line.settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos) return InvalidArgument("--set {}: expected KEY=VALUE", setting);
    ENFILADE_RETURN_IF_ERROR(Apply({setting.substr(0, equals), setting.substr(equals + 1)}, options));
  }
  ENFILADE_RETURN_IF_ERROR(options.Validate());
  return options;
}

absl::Status Run(const CommandLine& command_line) {
  ENFILADE_ASSIGN_OR_RETURN(const ServerOptions options, LoadOptions(command_line));
  if (command_line.print_config) {
    for (const Setting& setting : Describe(options)) std::cout << setting.key << ": " << setting.value << '\n';
    return absl::OkStatus();
  }
  SetUpLogging(options.log);

  // Only this thread receives signals, in sigwait(): threads that start from here on inherit the mask.
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);

  ENFILADE_ASSIGN_OR_RETURN(const slam::SlamProfiles slam, LoadSlamProfiles(options.mapping));
  ENFILADE_ASSIGN_OR_RETURN(const auto server, Server::Start(options, slam));
  spdlog::info("enfilade-server {} is listening on {}", kVersion, server->address());
  int signal = 0;
  sigwait(&signals, &signal);
  spdlog::info("signal {}", signal);
  server->Shutdown();
  return absl::OkStatus();
}

}  // namespace

int main(int argc, char** argv) {
  // If Abseil is built with assertions, as in Debian, it keeps a graph of the order of gRPC's locks, and aborts at a
  // cycle in it.
  absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore);
  CLI::App app("The map service of a fleet of robots.", "enfilade-server");
  app.set_version_flag("--version", std::string(kVersion));
  CommandLine command_line;
  app.add_option("--config", command_line.config, "A YAML file with options")->envname("ENFILADE_CONFIG");
  app.add_option("--set", command_line.settings,
                 "KEY=VALUE, for example listen.address=0.0.0.0:50051; may be repeated");
  app.add_flag("--print-config", command_line.print_config, "Print every option with its value and exit");
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = Run(command_line);
  if (status.ok()) return 0;
  std::cerr << "enfilade-server: " << status.message() << '\n';
  return absl::IsInvalidArgument(status) ? 2 : 1;
}
