// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/graph/linkpoint_output.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sdk/api/paging.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "proto/convert/record.h"

namespace enfilade::cli {
namespace {

using LinkPointStub = v1::LinkPointService::Stub;

struct LinkPointCommandOptions {
  std::string id;
  std::vector<std::string> places;
  std::string kind = "door";
  std::string tag;
  std::string map;
  std::string state;
  double for_s = 0.0;
  double radius_m = -1.0;
  std::vector<double> world;
  int nearest = 0;
  bool force = false;
  bool candidates = false;
};
using SharedLinkPointCommandOptions = std::shared_ptr<LinkPointCommandOptions>;

const std::map<std::string, v1::LinkPoint::Kind>& Kinds() {
  static const std::map<std::string, v1::LinkPoint::Kind> kinds = {{"door", v1::LinkPoint::KIND_DOOR},
                                                                   {"lift", v1::LinkPoint::KIND_LIFT},
                                                                   {"stairs", v1::LinkPoint::KIND_STAIRS},
                                                                   {"ramp", v1::LinkPoint::KIND_RAMP},
                                                                   {"opening", v1::LinkPoint::KIND_OPENING}};
  return kinds;
}

const std::map<std::string, v1::LinkPoint::State>& States() {
  static const std::map<std::string, v1::LinkPoint::State> states = {{"open", v1::LinkPoint::STATE_OPEN},
                                                                     {"closed", v1::LinkPoint::STATE_CLOSED},
                                                                     {"blocked", v1::LinkPoint::STATE_BLOCKED}};
  return states;
}

void PrintLinkPoint(const Globals& globals, const v1::LinkPoint& link_point, const std::string& what) {
  if (globals.json) return PrintJson(std::cout, LinkPointToJson(link_point));
  std::cout << what << '\n';
  PrintTable(std::cout, LinkPointHeader(), {LinkPointRow(link_point)});
}

absl::StatusOr<v1::Anchor> AnchorAt(const client::Connection& connection, const Globals& globals,
                                    const std::string& text) {
  ENFILADE_ASSIGN_OR_RETURN(const PoseInMap found, FindPoseInMap(connection, globals, text));
  v1::Anchor anchor;
  anchor.set_map(found.map);
  *anchor.mutable_pose_map_place()->mutable_pose() = convert::ToProto(found.pose);
  return anchor;
}

absl::Status CreateLinkPoint(const Globals& globals, const LinkPointCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  v1::CreateLinkPointRequest request;
  request.set_parent(SiteNameOf(globals));
  request.set_link_point_id(options.id);
  request.set_request_id(NewUuid());
  request.set_force(options.force);
  request.mutable_link_point()->set_kind(Kinds().at(options.kind));
  request.mutable_link_point()->set_tag(options.tag);
  for (const std::string& place : options.places) {
    ENFILADE_ASSIGN_OR_RETURN(*request.mutable_link_point()->add_anchors(), AnchorAt(connection, globals, place));
  }
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&LinkPointStub::CreateLinkPoint, request));
  PrintLinkPoint(globals, response.link_point(), "created " + response.link_point().name());
  return absl::OkStatus();
}

// Two places create a link point; one place promotes the candidate that --id names.
absl::Status SetLinkPoint(const Globals& globals, const LinkPointCommandOptions& options) {
  if (options.places.size() > 1) return CreateLinkPoint(globals, options);
  if (options.id.empty()) {
    return InvalidArgument("--at is given once: name the candidate to promote by --id, or give --at twice");
  }
  const client::Connection connection = ConnectionOf(globals);
  v1::AddLinkPointAnchorRequest request;
  request.set_name(ResourceNameOf(globals, "linkPoints", options.id));
  request.set_force(options.force);
  ENFILADE_ASSIGN_OR_RETURN(*request.mutable_anchor(), AnchorAt(connection, globals, options.places.front()));
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&LinkPointStub::AddLinkPointAnchor, request));
  PrintLinkPoint(globals, response.link_point(), response.link_point().name() + " joins one more map");
  return absl::OkStatus();
}

absl::Status SetCandidate(const Globals& globals, const LinkPointCommandOptions& options) {
  if (options.places.size() != 1) return InvalidArgument("a candidate is seen from one map only: give --at once");
  return CreateLinkPoint(globals, options);
}

absl::Status ListLinkPoints(const Globals& globals, const LinkPointCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  v1::ListLinkPointsRequest request;
  request.set_parent(SiteNameOf(globals));
  if (options.candidates) request.set_subset(v1::LINK_POINT_SUBSET_CANDIDATES);
  if (!options.map.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, options.map));
    request.set_map(map.name());
  }
  ENFILADE_ASSIGN_OR_RETURN(
      const std::vector<v1::LinkPoint> link_points,
      client::ListAll(connection, &LinkPointStub::ListLinkPoints, request, &v1::ListLinkPointsResponse::link_points));
  PrintList<v1::LinkPoint>(globals, link_points, LinkPointHeader(), LinkPointToJson, LinkPointRow);
  return absl::OkStatus();
}

absl::StatusOr<v1::FindLinkPointsRequest> SearchOf(const client::Connection& connection, const Globals& globals,
                                                   const LinkPointCommandOptions& options) {
  v1::FindLinkPointsRequest request;
  request.set_parent(SiteNameOf(globals));
  request.set_max_count(options.nearest);
  if (options.candidates) request.set_subset(v1::LINK_POINT_SUBSET_CANDIDATES);
  if (!options.world.empty()) {
    request.mutable_point_world()->set_x(options.world[0]);
    request.mutable_point_world()->set_y(options.world[1]);
    if (options.radius_m >= 0.0) request.set_radius_m(options.radius_m);
    return request;
  }
  if (options.places.empty()) return InvalidArgument("no place is given: use --at MAP,X,Y or --world X Y");
  ENFILADE_ASSIGN_OR_RETURN(const v1::Anchor anchor, AnchorAt(connection, globals, options.places.front()));
  request.mutable_pose_in_map()->set_map(anchor.map());
  *request.mutable_pose_in_map()->mutable_pose_map_robot() = anchor.pose_map_place();
  if (options.radius_m >= 0.0) request.set_base_radius_m(options.radius_m);
  return request;
}

nlohmann::json ToJson(const v1::FoundLinkPoint& found) {
  nlohmann::json document = LinkPointToJson(found.link_point());
  document["distance_m"] = found.distance_m();
  document["bearing_rad"] = found.bearing_rad();
  document["mahalanobis_distance"] = found.mahalanobis_distance();
  return document;
}

absl::Status FindNear(const Globals& globals, const LinkPointCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::FindLinkPointsRequest request, SearchOf(connection, globals, options));
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&LinkPointStub::FindLinkPoints, request));
  if (globals.json) {
    nlohmann::json documents = nlohmann::json::array();
    for (const v1::FoundLinkPoint& found : response.found()) documents.push_back(ToJson(found));
    PrintJson(std::cout, {{"graph_version", response.graph_version()},
                          {"radius_m", response.radius_m()},
                          {"found", std::move(documents)}});
    return absl::OkStatus();
  }
  std::vector<std::vector<std::string>> rows;
  for (const v1::FoundLinkPoint& found : response.found()) {
    rows.push_back(LinkPointRow(found.link_point()));
    rows.back().insert(rows.back().begin() + 1,
                       {fmt::format("{:.2f}", found.distance_m()), fmt::format("{:.2f}", found.bearing_rad())});
  }
  std::vector<std::string> header = LinkPointHeader();
  header.insert(header.begin() + 1, {"DISTANCE M", "BEARING RAD"});
  PrintTable(std::cout, header, rows);
  std::cout << fmt::format("within {:.2f} m, graph version {}\n", response.radius_m(), response.graph_version());
  return absl::OkStatus();
}

absl::Status SetState(const Globals& globals, const LinkPointCommandOptions& options) {
  v1::UpdateLinkPointRequest request;
  request.mutable_link_point()->set_name(ResourceNameOf(globals, "linkPoints", options.id));
  request.mutable_link_point()->set_state(States().at(options.state));
  request.mutable_update_mask()->add_paths("state");
  request.mutable_update_mask()->add_paths("state_valid_until");
  if (options.for_s > 0.0) {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    request.mutable_link_point()->mutable_state_valid_until()->set_seconds(
        std::chrono::duration_cast<std::chrono::seconds>(now + std::chrono::duration<double>(options.for_s)).count());
  }
  ENFILADE_ASSIGN_OR_RETURN(const auto response, ConnectionOf(globals).Call(&LinkPointStub::UpdateLinkPoint, request));
  PrintLinkPoint(globals, response.link_point(), response.link_point().name() + " is " + options.state);
  return absl::OkStatus();
}

template <typename Request, typename Response>
absl::Status ChangeLinkPoint(const Globals& globals, const LinkPointCommandOptions& options,
                             grpc::Status (LinkPointStub::*method)(grpc::ClientContext*, const Request&, Response*),
                             const std::string& what) {
  Request request;
  request.set_name(ResourceNameOf(globals, "linkPoints", options.id));
  ENFILADE_ASSIGN_OR_RETURN(const Response response, ConnectionOf(globals).Call(method, request));
  PrintLinkPoint(globals, response.link_point(), response.link_point().name() + what);
  return absl::OkStatus();
}

absl::Status DeleteLinkPoint(const Globals& globals, const LinkPointCommandOptions& options) {
  v1::DeleteLinkPointRequest request;
  request.set_name(ResourceNameOf(globals, "linkPoints", options.id));
  ENFILADE_RETURN_IF_ERROR(ConnectionOf(globals).Call(&LinkPointStub::DeleteLinkPoint, request).status());
  if (globals.json) {
    PrintJson(std::cout, {{"deleted", request.name()}});
  } else {
    std::cout << "deleted " << request.name() << '\n';
  }
  return absl::OkStatus();
}

void AddCreation(CLI::App& command, const SharedLinkPointCommandOptions& options) {
  command.add_option("--at", options->places, "Its pose in a map: MAP,X,Y,YAW in metres and radians")->required();
  command.add_option("--id", options->id, "Its id: 1 to 63 of a-z, 0-9 and \"-\" (default: a new one)");
  std::vector<std::string> kinds;
  for (const auto& [name, kind] : Kinds()) kinds.push_back(name);
  command.add_option("--kind", options->kind, "What it is")->check(CLI::IsMember(kinds))->capture_default_str();
  command.add_option("--tag", options->tag, "Free text");
  command.add_flag("--force", options->force, "Even if another one joins the same maps at the same place");
}

void AddSearches(CLI::App& group, const Globals& globals, const SharedLinkPointCommandOptions& options) {
  CLI::App* list =
      AddCommand(group, "list", "List link points", [&globals, options] { return ListLinkPoints(globals, *options); });
  list->add_option("--map", options->map, "Only those of this map");
  list->add_flag("--candidates", options->candidates, "Only candidates");
  list->footer("Example: enfilade linkpoint list --map Hall");
  CLI::App* near = AddCommand(group, "near", "Find link points near a pose or a point, the nearest first",
                              [&globals, options] { return FindNear(globals, *options); });
  near->add_option("--at", options->places, "Near a pose in a map: MAP,X,Y,YAW");
  near->add_option("--world", options->world, "Near a point of the world frame: X Y in metres")->expected(2);
  near->add_option("--radius", options->radius_m, "Metres (default: 20 around a pose, no limit around a point)");
  near->add_option("--nearest", options->nearest, "How many at most");
  near->add_flag("--candidates", options->candidates, "Only candidates");
  near->footer("Example: enfilade linkpoint near --at Hall,1,2,0 --radius 30");
}

void AddChanges(CLI::App& group, const Globals& globals, const SharedLinkPointCommandOptions& options) {
  CLI::App* state = AddCommand(group, "state", "Set whether robots can pass",
                               [&globals, options] { return SetState(globals, *options); });
  state->add_option("LINKPOINT", options->id, "Its id or resource name")->required();
  state->add_option("STATE", options->state, "open, closed or blocked")
      ->required()
      ->check(CLI::IsMember({"open", "closed", "blocked"}));
  state->add_option("--for", options->for_s, "Seconds until it counts as open again (default: no end)");
  state->footer("Example: enfilade linkpoint state door-3 blocked --for 3600");
  const auto add_named = [&](const std::string& name, const std::string& description, auto run) {
    CLI::App* command = AddCommand(group, name, description, run);
    command->add_option("LINKPOINT", options->id, "Its id or resource name")->required();
    command->footer("Example: enfilade linkpoint " + name + " door-3");
  };
  add_named("suspend", "Leave one out of pose chains, routes and the optimisation", [&globals, options] {
    return ChangeLinkPoint(globals, *options, &LinkPointStub::SuspendLinkPoint, " is suspended");
  });
  add_named("resume", "Use a suspended one again", [&globals, options] {
    return ChangeLinkPoint(globals, *options, &LinkPointStub::ResumeLinkPoint, " is used again");
  });
  add_named("delete", "Delete one with its evidence",
            [&globals, options] { return DeleteLinkPoint(globals, *options); });
}

}  // namespace

void AddLinkPoint(CLI::App& app, const Globals& globals) {
  CLI::App* group = app.add_subcommand("linkpoint", "Link points: the places where maps meet");
  group->require_subcommand(1);
  const auto options = std::make_shared<LinkPointCommandOptions>();
  CLI::App* set = AddCommand(*group, "set", "Join maps at a place, or promote a candidate",
                             [&globals, options] { return SetLinkPoint(globals, *options); });
  AddCreation(*set, options);
  set->footer(
      "Examples: enfilade linkpoint set --at Hall,12.5,3,0 --at Lab,0,0,3.14 --tag \"north door\"\n"
      "          enfilade linkpoint set --id door-3 --at Lab,0,0,3.14");
  CLI::App* candidate =
      AddCommand(*group, "candidate", "Create a candidate: a place seen from one map that may join another",
                 [&globals, options] { return SetCandidate(globals, *options); });
  AddCreation(*candidate, options);
  candidate->footer("Example: enfilade linkpoint candidate --id door-3 --at Hall,20,1,1.57");
  AddSearches(*group, globals, options);
  AddChanges(*group, globals, options);
  AddLinkPointChange(*group, globals);
  AddLinkPointPins(*group, globals);
}

}  // namespace enfilade::cli
