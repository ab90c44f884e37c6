// SPDX-License-Identifier: Apache-2.0
// `enfilade prior associations`, `shafts` and `doors`.
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sdk/api/paging.h"
#include "client/sdk/api/prior_maps.h"
#include "core/base/status_macros.h"
#include "core/geometry/pose2.h"
#include "enfilade/v1/prior_map_service.grpc.pb.h"
#include "fmt/format.h"

namespace enfilade::cli {
namespace {

using PriorMapStub = v1::PriorMapService::Stub;

nlohmann::json PlaceToJson(const v1::Pose2& pose) { return {{"x", pose.x()}, {"y", pose.y()}, {"yaw", pose.yaw()}}; }

nlohmann::json AssociationToJson(const v1::PriorAssociation& one) {
  return {{"wall", one.wall()},
          {"map", one.map()},
          {"pose_map_line", PlaceToJson(one.pose_map_line())},
          {"length_m", one.length_m()},
          {"state", EnumText(v1::PriorAssociation::State_Name(one.state()), "STATE_")},
          {"across_m", one.across_m()},
          {"turn_rad", one.turn_rad()},
          {"chi2", one.chi2()}};
}

std::vector<std::string> AssociationRow(const v1::PriorAssociation& one) {
  return {IdOf(one.map()),
          std::to_string(one.wall()),
          EnumText(v1::PriorAssociation::State_Name(one.state()), "STATE_"),
          fmt::format("{:.1f}", one.length_m()),
          fmt::format("{:+.3f}", one.across_m()),
          fmt::format("{:+.2f}", one.turn_rad() / kDegree),
          fmt::format("{:.1f}", one.chi2())};
}

nlohmann::json ShaftToJson(const v1::PriorShaft& shaft) {
  return {{"name", shaft.name()},
          {"other_prior_map", shaft.other_prior_map()},
          {"state", EnumText(v1::PriorAssociation::State_Name(shaft.state()), "STATE_")},
          {"distance_m", shaft.distance_m()},
          {"chi2", shaft.chi2()}};
}

std::vector<std::string> ShaftRow(const v1::PriorShaft& shaft) {
  return {shaft.name(), IdOf(shaft.other_prior_map()),
          EnumText(v1::PriorAssociation::State_Name(shaft.state()), "STATE_"),
          fmt::format("{:.3f}", shaft.distance_m()), fmt::format("{:.1f}", shaft.chi2())};
}

nlohmann::json DoorToJson(const v1::PredictedLinkPoint& door) {
  return {{"door", door.door()},
          {"pose_world_place", PlaceToJson(door.pose_world_place())},
          {"width_m", door.width_m()},
          {"sigma_m", door.sigma_m()},
          {"seen", door.seen()},
          {"link_point", door.link_point()},
          {"candidates", std::vector<std::string>(door.candidates().begin(), door.candidates().end())},
          {"joined_by_plan", door.joined_by_plan()},
          {"reason", door.reason()}};
}

std::vector<std::string> DoorRow(const v1::PredictedLinkPoint& door) {
  return {std::to_string(door.door()),
          fmt::format("{:.2f}", door.pose_world_place().x()),
          fmt::format("{:.2f}", door.pose_world_place().y()),
          fmt::format("{:.2f}", door.width_m()),
          fmt::format("{:.2f}", door.sigma_m()),
          door.seen() ? "yes" : "no",
          std::string(IdOf(door.link_point())) + (door.joined_by_plan() ? " (by the plan)" : ""),
          std::to_string(door.candidates_size()),
          door.reason()};
}

// Prints what belongs to a plan.
template <typename Item, typename Request, typename Response>
absl::Status ListOfPlan(const Globals& globals, const std::string& plan,
                        grpc::Status (PriorMapStub::*method)(grpc::ClientContext*, const Request&, Response*),
                        const google::protobuf::RepeatedPtrField<Item>& (Response::*items)() const,
                        const std::vector<std::string>& header, nlohmann::json (*to_json)(const Item&),
                        std::vector<std::string> (*to_row)(const Item&)) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::PriorMap found, client::FindPriorMap(connection, SiteId(globals.site), plan));
  Request request;
  request.set_parent(found.name());
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<Item> listed, client::ListAll(connection, method, request, items));
  PrintList<Item>(globals, listed, header, to_json, to_row);
  return absl::OkStatus();
}

}  // namespace

void AddPriorTies(CLI::App& prior, const Globals& globals) {
  const auto plan = std::make_shared<std::string>();
  CLI::App* associations = AddCommand(
      prior, "associations", "List the walls of a plan that maps have seen, and how they fit", [&globals, plan] {
        return ListOfPlan<v1::PriorAssociation>(
            globals, *plan, &PriorMapStub::ListPriorAssociations, &v1::ListPriorAssociationsResponse::associations,
            {"MAP", "WALL", "STATE", "LENGTH_M", "ACROSS_M", "TURN_DEG", "CHI2"}, AssociationToJson, AssociationRow);
      });
  associations->footer("Example: enfilade prior associations \"Ground floor\"");
  CLI::App* shafts = AddCommand(
      prior, "shafts", "List the lifts and stairs that tie a plan to those of other levels", [&globals, plan] {
        return ListOfPlan<v1::PriorShaft>(
            globals, *plan, &PriorMapStub::ListPriorAssociations, &v1::ListPriorAssociationsResponse::shafts,
            {"SHAFT", "OTHER_PLAN", "STATE", "DISTANCE_M", "CHI2"}, ShaftToJson, ShaftRow);
      });
  shafts->footer("Example: enfilade prior shafts \"First floor\"");
  CLI::App* doors =
      AddCommand(prior, "doors", "List a plan's doors, and which of them have link points", [&globals, plan] {
        return ListOfPlan<v1::PredictedLinkPoint>(
            globals, *plan, &PriorMapStub::ListPredictedLinkPoints, &v1::ListPredictedLinkPointsResponse::predicted,
            {"DOOR", "X_M", "Y_M", "WIDTH_M", "SIGMA_M", "SEEN", "LINK_POINT", "CANDIDATES", "REASON"}, DoorToJson,
            DoorRow);
      });
  doors->footer("Example: enfilade prior doors \"Ground floor\"");
  for (CLI::App* command : {associations, shafts, doors}) {
    command->add_option("PLAN", *plan, "Its name, id or resource name")->required();
  }
}

}  // namespace enfilade::cli
