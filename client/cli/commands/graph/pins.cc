// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <string>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"

namespace enfilade::cli {
namespace {

void PrintPin(const Globals& globals, const std::string& name, bool pinned) {
  if (globals.json) {
    PrintJson(std::cout, {{"name", name}, {"pinned", pinned}});
  } else {
    std::cout << name
              << (pinned ? " is pinned: surveys leave it as it is\n" : " is not pinned: surveys may change it\n");
  }
}

absl::Status PinMap(const Globals& globals, const std::string& name, bool pinned) {
  const client::Connection connection = ConnectionOf(globals);
  v1::UpdateMapRequest request;
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, name));
  request.mutable_map()->set_name(map.name());
  request.mutable_map()->set_pinned(pinned);
  request.mutable_update_mask()->add_paths("pinned");
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&v1::MapService::Stub::UpdateMap, request));
  PrintPin(globals, response.map().name(), response.map().pinned());
  return absl::OkStatus();
}

absl::Status PinLinkPoint(const Globals& globals, const std::string& id, bool pinned) {
  v1::UpdateLinkPointRequest request;
  request.mutable_link_point()->set_name(ResourceNameOf(globals, "linkPoints", id));
  request.mutable_link_point()->set_pinned(pinned);
  request.mutable_update_mask()->add_paths("pinned");
  ENFILADE_ASSIGN_OR_RETURN(const auto response,
                            ConnectionOf(globals).Call(&v1::LinkPointService::Stub::UpdateLinkPoint, request));
  PrintPin(globals, response.link_point().name(), response.link_point().pinned());
  return absl::OkStatus();
}

}  // namespace

void AddMapPins(CLI::App& map, const Globals& globals) {
  for (const bool pinned : {true, false}) {
    const auto name = std::make_shared<std::string>();
    CLI::App* command = AddCommand(
        map, pinned ? "pin" : "unpin",
        pinned ? "Keep a map's sessions together, whatever surveys find" : "Let surveys divide and join a map again",
        [&globals, name, pinned] { return PinMap(globals, *name, pinned); });
    command->add_option("MAP", *name, "Its name, id or resource name")->required();
    command->footer(std::string("Example: enfilade map ") + (pinned ? "pin" : "unpin") + " \"Corridor\"");
  }
}

void AddLinkPointPins(CLI::App& linkpoint, const Globals& globals) {
  for (const bool pinned : {true, false}) {
    const auto id = std::make_shared<std::string>();
    CLI::App* command =
        AddCommand(linkpoint, pinned ? "pin" : "unpin",
                   pinned ? "Keep one where it is, whatever surveys find" : "Let surveys move and remove one again",
                   [&globals, id, pinned] { return PinLinkPoint(globals, *id, pinned); });
    command->add_option("LINKPOINT", *id, "Its id or resource name")->required();
    command->footer(std::string("Example: enfilade linkpoint ") + (pinned ? "pin" : "unpin") + " door-3");
  }
}

}  // namespace enfilade::cli
