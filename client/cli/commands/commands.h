// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "client/cli/command.h"

namespace enfilade::cli {

// Each adds one command of the tool, with its subcommands, to `app`. `globals` outlives the app and is read when the
// command runs.

// A server's site: one file per command below commands/, named after it.
void AddArea(CLI::App& app, const Globals& globals);  // area add | list | show | update | delete | export
void AddGraph(CLI::App& app,
              const Globals& globals);  // graph show | versions | diff | change | optimize | export | plot | solve
void AddImport(CLI::App& app, const Globals& globals);       // import mapmanager | building
void AddLinkPoint(CLI::App& app, const Globals& globals);    // linkpoint set | candidate | list | near | state | ...
void AddLoopClosure(CLI::App& app, const Globals& globals);  // closure list | suspend | resume
void AddLocalize(CLI::App& app, const Globals& globals);
// map list | show | create | update | draft | edit | publish | rebase | contested | export | import | diff | alias |
// restore | merge | split | undo | rearrangements | delete
void AddMap(CLI::App& app, const Globals& globals);
void AddPose(CLI::App& app, const Globals& globals);  // pose global | watch; route
// prior list | show | add | edit | align | activate | suspend | rename | export | publish | delete; import | fit |
// locate need no server
void AddPrior(CLI::App& app, const Globals& globals);
void AddReplay(CLI::App& app, const Globals& globals);
void AddRobot(CLI::App& app, const Globals& globals);
void AddServer(CLI::App& app, const Globals& globals);      // server status
void AddSession(CLI::App& app, const Globals& globals);     // session list | show | doors
void AddSite(CLI::App& app, const Globals& globals);        // site create | list | audit
void AddTrajectory(CLI::App& app, const Globals& globals);  // trajectory export

// Files alone, without a server.
void AddDoors(CLI::App& app, const Globals& globals);
void AddEnvironment(CLI::App& app, const Globals& globals);
void AddMatch(CLI::App& app, const Globals& globals);  // match images | clouds
void AddRooms(CLI::App& app, const Globals& globals);
void AddSimulate(CLI::App& app, const Globals& globals);
void AddSlam(CLI::App& app, const Globals& globals);

void AddCompletion(CLI::App& app);
void AddManual(CLI::App& app);

// Parts of the commands above that have a file of their own. The first parameter is the command that they belong to.
void AddAreaEdit(CLI::App& area, const Globals& globals);  // add, update
void AddGraphDiff(CLI::App& graph, const Globals& globals);
void AddGraphPlot(CLI::App& graph, const Globals& globals);
void AddGraphSolve(CLI::App& graph, const Globals& globals);
void AddMapAlias(CLI::App& map, const Globals& globals);  // alias set | list | rollback | delete; restore
void AddMapDiff(CLI::App& map, const Globals& globals);
void AddGraphChange(CLI::App& graph, const Globals& globals);
void AddLinkPointChange(CLI::App& linkpoint, const Globals& globals);  // move, undo
void AddLinkPointPins(CLI::App& linkpoint, const Globals& globals);    // pin, unpin
void AddMapAlign(CLI::App& map, const Globals& globals);
void AddMapEdit(CLI::App& map, const Globals& globals);
void AddMapContested(CLI::App& map, const Globals& globals);
void AddMapDraft(CLI::App& map, const Globals& globals);
void AddMapEditFile(CLI::App& map, const Globals& globals);  // edit
void AddMapExport(CLI::App& map, const Globals& globals);
void AddMapImport(CLI::App& map, const Globals& globals);
void AddMapPins(CLI::App& map, const Globals& globals);     // pin, unpin
void AddMapPublish(CLI::App& map, const Globals& globals);  // publish, rebase
void AddMapRearrange(CLI::App& map, const Globals& globals);
void AddMatchClouds(CLI::App& match, const Globals& globals);
void AddMatchImages(CLI::App& match, const Globals& globals);
void AddPriorAdd(CLI::App& prior, const Globals& globals);
void AddPriorAlign(CLI::App& prior, const Globals& globals);
void AddPriorEdit(CLI::App& prior, const Globals& globals);
void AddPriorExport(CLI::App& prior, const Globals& globals);
void AddPriorPublish(CLI::App& prior, const Globals& globals);
void AddPriorFit(CLI::App& prior, const Globals& globals);
void AddPriorImport(CLI::App& prior, const Globals& globals);
void AddPriorLocate(CLI::App& prior, const Globals& globals);
void AddPriorMaps(CLI::App& prior, const Globals& globals);  // list, show, activate, suspend, rename, delete
void AddPriorTies(CLI::App& prior, const Globals& globals);  // associations, doors
void AddSessionDoors(CLI::App& session, const Globals& globals);

}  // namespace enfilade::cli
