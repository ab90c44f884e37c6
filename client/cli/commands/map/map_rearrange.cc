// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sdk/api/paging.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/geometry/pose2.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "fmt/format.h"

namespace enfilade::cli {
namespace {

// Of all shown: older ones are rarely of interest.
constexpr int kShownRearrangements = 100;

nlohmann::json RearrangementToJson(const v1::Rearrangement& rearrangement) {
  nlohmann::json document = {{"name", rearrangement.name()},
                             {"reason", rearrangement.reason()},
                             {"actor", rearrangement.actor()},
                             {"create_time", FormatTime(rearrangement.create_time())},
                             {"graph_version", rearrangement.graph_version()},
                             {"undone", rearrangement.undo_graph_version() != 0},
                             {"undo_expired", rearrangement.undo_expired()}};
  for (const v1::MergedMap& merged : rearrangement.merged_maps()) {
    const v1::Pose2& pose = merged.pose_into_map();
    document["merged_maps"].push_back(
        {{"map", merged.map()}, {"into", merged.into()}, {"pose_into_map", {pose.x(), pose.y(), pose.yaw()}}});
  }
  for (const v1::MovedSession& moved : rearrangement.moved_sessions()) {
    document["moved_sessions"].push_back({{"session", moved.session()}, {"map", moved.map()}});
  }
  for (const v1::SessionCut& cut : rearrangement.cut_sessions()) {
    document["cut_sessions"].push_back(
        {{"session", cut.session()}, {"first_sequence", cut.first_sequence()}, {"rest", cut.rest()}});
  }
  document["new_maps"] = std::vector<std::string>(rearrangement.new_maps().begin(), rearrangement.new_maps().end());
  document["changed_link_points"] =
      std::vector<std::string>(rearrangement.changed_link_points().begin(), rearrangement.changed_link_points().end());
  document["removed_link_points"] =
      std::vector<std::string>(rearrangement.removed_link_points().begin(), rearrangement.removed_link_points().end());
  return document;
}

const char* StateOf(const v1::Rearrangement& rearrangement) {
  if (rearrangement.undo_graph_version() != 0) return "undone";
  return rearrangement.undo_expired() ? "permanent" : "in effect";
}

void PrintRearrangement(const Globals& globals, const std::string& what, const v1::Rearrangement& rearrangement) {
  if (globals.json) {
    PrintJson(std::cout, RearrangementToJson(rearrangement));
    return;
  }
  std::cout << what << ": " << rearrangement.reason() << "\n"
            << rearrangement.moved_sessions_size() << " sessions moved, " << rearrangement.changed_link_points_size()
            << " link points changed, " << rearrangement.removed_link_points_size() << " removed; "
            << rearrangement.name() << '\n';
}

struct MergeCommandOptions {
  std::string kept;
  std::string merged;
  std::vector<double> pose;  // m, m, degrees
};

absl::Status RunMerge(const Globals& globals, const MergeCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map kept, FindMap(connection, globals, options.kept));
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map merged, FindMap(connection, globals, options.merged));
  v1::MergeMapsRequest request;
  request.set_name(kept.name());
  request.set_merged_map(merged.name());
  if (!options.pose.empty()) {
    v1::Pose2& pose = *request.mutable_pose_name_merged();
    pose.set_x(options.pose[0]);
    pose.set_y(options.pose[1]);
    pose.set_yaw(options.pose[2] * kDegree);
  }
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&v1::MapService::Stub::MergeMaps, request));
  PrintRearrangement(globals, "merged into \"" + response.map().display_name() + "\"", response.rearrangement());
  return absl::OkStatus();
}

struct SplitCommandOptions {
  std::string map;
  std::vector<std::string> sessions;
  std::string id;
};

// SESSION, or SESSION@SEQUENCE for its rest from that record on.
absl::Status AddLeaving(const Globals& globals, const std::string& leaving, v1::SplitMapRequest& request) {
  const std::size_t at = leaving.find('@');
  const std::string session = leaving.substr(0, at);
  const std::string name =
      session.rfind("sites/", 0) == 0 ? session : fmt::format("{}/sessions/{}", SiteNameOf(globals), session);
  if (at == std::string::npos) {
    request.add_sessions(name);
    return absl::OkStatus();
  }
  std::size_t read = 0;
  const std::string number = leaving.substr(at + 1);
  long long sequence = 0;
  try {
    sequence = std::stoll(number, &read);
  } catch (const std::exception&) {
    read = 0;
  }
  if (read == 0 || read != number.size()) {
    return InvalidArgument("\"{}\" is not a session and the sequence of a record, such as s1@1200", leaving);
  }
  v1::SessionCut& cut = *request.add_cuts();
  cut.set_session(name);
  cut.set_first_sequence(sequence);
  return absl::OkStatus();
}

absl::Status RunSplit(const Globals& globals, const SplitCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, options.map));
  v1::SplitMapRequest request;
  request.set_name(map.name());
  request.set_map_id(options.id);
  for (const std::string& leaving : options.sessions) ENFILADE_RETURN_IF_ERROR(AddLeaving(globals, leaving, request));
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&v1::MapService::Stub::SplitMap, request));
  PrintRearrangement(globals, "new map \"" + response.map().display_name() + "\"", response.rearrangement());
  return absl::OkStatus();
}

absl::Status RunUndo(const Globals& globals, const std::string& rearrangement) {
  v1::UndoRearrangementRequest request;
  request.set_name(rearrangement.rfind("sites/", 0) == 0
                       ? rearrangement
                       : fmt::format("{}/rearrangements/{}", SiteNameOf(globals), rearrangement));
  ENFILADE_ASSIGN_OR_RETURN(const auto response,
                            ConnectionOf(globals).Call(&v1::MapService::Stub::UndoRearrangement, request));
  PrintRearrangement(globals, "undone", response.rearrangement());
  return absl::OkStatus();
}

absl::Status ListRearrangements(const Globals& globals) {
  v1::ListRearrangementsRequest request;
  request.set_parent(SiteNameOf(globals));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<v1::Rearrangement> listed,
                            client::ListAll(ConnectionOf(globals), &v1::MapService::Stub::ListRearrangements, request,
                                            &v1::ListRearrangementsResponse::rearrangements, kShownRearrangements));
  PrintList<v1::Rearrangement>(globals, listed, {"REARRANGEMENT", "MADE (UTC)", "GRAPH", "STATE", "BY", "REASON"},
                               RearrangementToJson, [](const v1::Rearrangement& rearrangement) {
                                 return std::vector<std::string>{IdOf(rearrangement.name()),
                                                                 FormatTime(rearrangement.create_time()),
                                                                 std::to_string(rearrangement.graph_version()),
                                                                 StateOf(rearrangement),
                                                                 rearrangement.actor(),
                                                                 rearrangement.reason()};
                               });
  return absl::OkStatus();
}

}  // namespace

void AddMapRearrange(CLI::App& map, const Globals& globals) {
  const auto merge_options = std::make_shared<MergeCommandOptions>();
  CLI::App* merge = AddCommand(map, "merge", "Make one map of two that are one room",
                               [&globals, merge_options] { return RunMerge(globals, *merge_options); });
  merge->add_option("MAP", merge_options->kept, "The map that stays: its name, id or resource name")->required();
  merge->add_option("OTHER", merge_options->merged, "The map that becomes a part of it; its names lead there")
      ->required();
  merge
      ->add_option("--pose", merge_options->pose,
                   "The frame of OTHER in that of MAP: X Y YAW, m and degrees (default: by the link points)")
      ->expected(3);
  merge->footer("Example: enfilade map merge \"Corridor\" \"Map 7\"\nUndo it with enfilade map undo.");

  const auto split_options = std::make_shared<SplitCommandOptions>();
  CLI::App* split = AddCommand(map, "split", "Take sessions out of a map into a new one",
                               [&globals, split_options] { return RunSplit(globals, *split_options); });
  split->add_option("MAP", split_options->map, "Its name, id or resource name")->required();
  split
      ->add_option("SESSION", split_options->sessions,
                   "The sessions that leave: SESSION, or SESSION@SEQUENCE for the rest of it from that record on")
      ->required();
  split->add_option("--id", split_options->id, "The new map's id (default: a new one)");
  split->footer("Example: enfilade map split \"Corridor\" s17 s18@4200");

  const auto rearrangement = std::make_shared<std::string>();
  CLI::App* undo = AddCommand(
      map, "undo", "Undo a merge or split, if nothing has changed since and the server still keeps what that needs",
      [&globals, rearrangement] { return RunUndo(globals, *rearrangement); });
  undo->add_option("REARRANGEMENT", *rearrangement, "Its id or resource name (enfilade map rearrangements)")
      ->required();
  AddCommand(map, "rearrangements", "List merges and splits, the newest first",
             [&globals] { return ListRearrangements(globals); });
}

}  // namespace enfilade::cli
