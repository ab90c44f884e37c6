// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <iostream>

#include "absl/synchronization/mutex.h"
#include "client/cli/command.h"
#include "client/cli/commands/completion.h"
#include "client/cli/commands/graph/graph_remote.h"
#include "client/cli/commands/graph/graph_solve.h"
#include "client/cli/commands/graph/linkpoint.h"
#include "client/cli/commands/graph/pose.h"
#include "client/cli/commands/map/import_sources.h"
#include "client/cli/commands/map/map.h"
#include "client/cli/commands/offline/doors.h"
#include "client/cli/commands/offline/environment.h"
#include "client/cli/commands/offline/match.h"
#include "client/cli/commands/offline/sim.h"
#include "client/cli/commands/offline/simulate.h"
#include "client/cli/commands/offline/slam.h"
#include "client/cli/commands/robot.h"
#include "client/cli/commands/server.h"
#include "client/cli/commands/session/closure.h"
#include "client/cli/commands/session/replay.h"
#include "client/cli/commands/session/session.h"
#include "client/cli/commands/session/trajectory.h"
#include "client/cli/commands/site.h"

int main(int argc, char** argv) {
  using namespace enfilade::cli;
  // Built with assertions, as Debian's, Abseil keeps a graph of the order of gRPC's locks, and aborts at a cycle in it.
  absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore);
  CLI::App app("Enfilade: one campus map for a fleet of robots.", "enfilade");
  app.require_subcommand(1);
  app.fallthrough();
  Globals globals;
  app.add_flag("--json", globals.json, "Print JSON for programs");
  app.add_flag("-q,--quiet", globals.quiet, "No progress bars");
  app.add_option("--server", globals.server, "The server: host:port or unix:/path")
      ->envname("ENFILADE_SERVER")
      ->capture_default_str();
  app.add_option("--timeout", globals.timeout_s, "Deadline of one call in seconds")->capture_default_str();
  app.add_option("--site", globals.site, "The site's id")->envname("ENFILADE_SITE")->capture_default_str();
  if (const char* user = std::getenv("USER")) globals.actor = user;
  app.add_option("--actor", globals.actor, "Who you are, for the audit trail (default: $USER)")
      ->envname("ENFILADE_ACTOR");
  AddLoopClosure(app, globals);
  AddDoors(app, globals);
  AddEnvironment(app, globals);
  AddGraph(app, globals);
  AddGraphRemote(app, globals);
  AddImport(app, globals);
  AddLinkPoint(app, globals);
  AddMap(app, globals);
  AddMatch(app, globals);
  AddPose(app, globals);
  AddReplay(app, globals);
  AddRobot(app, globals);
  AddServer(app, globals);
  AddSession(app, globals);
  AddSim(app, globals);
  AddSimulate(app, globals);
  AddSite(app, globals);
  AddSlam(app, globals);
  AddTrajectory(app, globals);
  AddCompletion(app);
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
