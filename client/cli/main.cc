// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <iostream>

#include "absl/synchronization/mutex.h"
#include "client/cli/command.h"
#include "client/cli/commands/commands.h"
#include "core/base/version.h"

int main(int argc, char** argv) {
  using namespace enfilade::cli;
  // Debian builds Abseil with assertions: then it records the order in which gRPC takes its locks, and aborts at a
  // cycle.
  absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore);
  CLI::App app("Enfilade: one campus map for a fleet of robots.", "enfilade");
  app.require_subcommand(1);
  app.fallthrough();
  app.set_version_flag("--version", std::string(enfilade::kVersion));
  Globals globals;
  app.add_flag("--json", globals.json, "Print JSON");
  app.add_flag("-q,--quiet", globals.quiet, "No progress bars");
  app.add_option("--server", globals.server, "The server: host:port or unix:/path")
      ->envname("ENFILADE_SERVER")
      ->capture_default_str();
  app.add_option("--tls-authorities", globals.tls.authorities,
                 "PEM file: whose word is taken for who the server is; speaks TLS")
      ->envname("ENFILADE_TLS_AUTHORITIES");
  app.add_option("--tls-certificate", globals.tls.certificate,
                 "PEM file: your own certificate, if the server asks for one")
      ->envname("ENFILADE_TLS_CERTIFICATE");
  app.add_option("--tls-key", globals.tls.key, "PEM file: its key")->envname("ENFILADE_TLS_KEY");
  app.add_option("--timeout", globals.timeout_s, "Deadline of one call, seconds")->capture_default_str();
  app.add_option("--site", globals.site, "The site's id")->envname("ENFILADE_SITE")->capture_default_str();
  if (const char* user = std::getenv("USER")) globals.actor = user;
  app.add_option("--actor", globals.actor, "Your name for the audit trail (default: $USER)")->envname("ENFILADE_ACTOR");
  AddArea(app, globals);
  AddLoopClosure(app, globals);
  AddDoors(app, globals);
  AddEnvironment(app, globals);
  AddGraph(app, globals);
  AddImport(app, globals);
  AddLinkPoint(app, globals);
  AddLocalize(app, globals);
  AddMap(app, globals);
  AddMatch(app, globals);
  AddPose(app, globals);
  AddPrior(app, globals);
  AddReplay(app, globals);
  AddRobot(app, globals);
  AddRooms(app, globals);
  AddServer(app, globals);
  AddSession(app, globals);
  AddSimulate(app, globals);
  AddSite(app, globals);
  AddSlam(app, globals);
  AddTrajectory(app, globals);
  AddCompletion(app);
  AddManual(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const CommandFailed& failed) {
    std::cerr << "enfilade: " << failed.status.message() << '\n';
    return ExitCodeOf(failed.status);
  }
  return 0;
}
