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
#include "core/base/version.h"
#include "fmt/format.h"
#include "io/file.h"
#include "io/manual/man_page.h"
#include "server/app/runtime/logging.h"
#include "server/app/runtime/service_manager.h"
#include "server/config/server_options.h"
#include "server/config/slam_profiles.h"
#include "server/server.h"
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

// Applies what may change while the server runs, and says what else has changed.
void Reload(const CommandLine& command_line, const ServerOptions& running) {
  const absl::StatusOr<ServerOptions> loaded = LoadOptions(command_line);
  if (!loaded.ok()) {
    spdlog::error("the configuration is not reloaded: {}", std::string(loaded.status().message()));
    return;
  }
  spdlog::set_level(spdlog::level::from_str(loaded->log.level));
  const std::vector<Setting> before = Describe(running), after = Describe(*loaded);
  for (std::size_t i = 0; i < after.size(); ++i) {
    if (after[i].key == "log.level" || after[i].value == before[i].value) continue;
    spdlog::warn("{} has changed: restart the server to use it", after[i].key);
  }
  spdlog::info("the configuration is reloaded");
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
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&signals, signal);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);

  ENFILADE_ASSIGN_OR_RETURN(const slam::SlamProfiles slam, LoadSlamProfiles(options.mapping));
  ENFILADE_ASSIGN_OR_RETURN(const auto server, Server::Start(options, slam));
  spdlog::info("enfilade-server {} is listening on {}", kVersion, server->address());
  NotifyReady();
  int signal = 0;
  while (sigwait(&signals, &signal), signal == SIGHUP) {
    NotifyReloading();
    Reload(command_line, options);
    NotifyReady();
  }
  spdlog::info("signal {}", signal);
  NotifyStopping();
  server->Shutdown();
  return absl::OkStatus();
}

// All options with their defaults, for the manual page.
std::string OptionList() {
  std::string list;
  for (const Setting& setting : Describe(ServerOptions()))
    list += fmt::format("  {}: {}\n", setting.key, setting.value);
  return list;
}

std::string Manual(const CLI::App& app) {
  return io::ManPage(
      app, "enfilade-server",
      {.section = 8,
       .version = kVersion,
       .see_also = ".BR enfilade (1),\n.BR enfilade\\-gateway (8),\n.BR enfilade\\-migrate (8)",
       .sections = {
           {"CONFIGURATION",
            "Options come from the file that --config names, from the environment, and from --set; later ones win. In "
            "the "
            "environment, ENFILADE_SERVER_DATABASE_URL is database.url. In the file, groups are mappings:\n  listen:\n"
            "    address: 127.0.0.1:50051\nThe options with their defaults are:\n" +
                OptionList()},
           {"SIGNALS",
            "TERM and INT end the server: streams are answered and ended, checkpoints are stored. HUP reads the "
            "configuration again and applies log.level; the log names what else has changed and needs a restart. TLS "
            "files are read by themselves when they change."},
           {"FILES", "  /etc/enfilade/server.yaml\n  /etc/enfilade/server.env"},
           {"EXIT STATUS", "0: ended by a signal; 1: an error; 2: the options are wrong."}}});
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
  bool print_manual = false;
  app.add_flag("--print-manual", print_manual, "Print the manual page, for man(7), and exit");
  app.add_flag("--print-config", command_line.print_config, "Print every option with its value and exit");
  CLI11_PARSE(app, argc, argv);
  if (print_manual) {
    std::cout << Manual(app);
    return 0;
  }
  const absl::Status status = Run(command_line);
  if (status.ok()) return 0;
  std::cerr << "enfilade-server: " << status.message() << '\n';
  return absl::IsInvalidArgument(status) ? 2 : 1;
}
