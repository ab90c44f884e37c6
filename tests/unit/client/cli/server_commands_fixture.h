// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/commands/commands.h"
#include "tests/support/scripted_server.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/client/cli/command_test.h"

namespace enfilade::cli {

// Runs commands against a scripted server with the maps Hall (sites/s/maps/h) and Lab (sites/s/maps/l).
class ServerCommandsTest : public CommandTest {
 protected:
  ServerCommandsTest() {
    globals_.server = server_.address();
    globals_.site = "s";
    globals_.actor = "ann";
    globals_.timeout_s = 20.0;
    server_.maps.list_maps = [](const v1::ListMapsRequest& request, v1::ListMapsResponse& response) {
      for (const std::string name : {"Hall", "Lab"}) {
        if (!request.display_name().empty() && request.display_name() != name) continue;
        v1::Map& map = *response.add_maps();
        map.set_name("sites/s/maps/" + std::string(name == "Hall" ? "h" : "l"));
        map.set_display_name(name);
        map.set_level(name == "Hall" ? 0 : 1);
        map.set_environment(name == "Hall" ? v1::Map::ENVIRONMENT_INDOOR : v1::Map::ENVIRONMENT_OUTDOOR);
        map.set_etag("e-" + name);
        if (name == "Lab") map.set_latest_revision("sites/s/maps/l/revisions/4");
      }
      return grpc::Status::OK;
    };
    server_.maps.get_map = [](const v1::GetMapRequest&, v1::GetMapResponse&) {
      return grpc::Status(grpc::StatusCode::NOT_FOUND, "no map");
    };
  }

  absl::Status Run(std::vector<std::string> arguments, bool as_json = true) {
    const auto add = [](CLI::App& app, const Globals& globals) {
      AddGraph(app, globals);
      AddImport(app, globals);
      AddLinkPoint(app, globals);
      AddLoopClosure(app, globals);
      AddLocalize(app, globals);
      AddMap(app, globals);
      AddPose(app, globals);
      AddReplay(app, globals);
      AddServer(app, globals);
      AddSession(app, globals);
      AddSite(app, globals);
      AddTrajectory(app, globals);
      AddCompletion(app);
      AddManual(app);
    };
    return RunCommandLine(add, std::move(arguments), as_json);
  }
  nlohmann::json Printed() const { return nlohmann::json::parse(printed_, nullptr, false); }

  enfilade::testing::ScriptedServer server_{(directory_.path() / "s").string()};
};

}  // namespace enfilade::cli
