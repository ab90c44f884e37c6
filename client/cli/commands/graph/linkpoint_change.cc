// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/graph/graph_changes.h"
#include "client/cli/numbers.h"
#include "client/cli/remote.h"
#include "client/sdk/editing/graph_undo.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/geometry/pose2.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "proto/convert/geometry.h"
#include "proto/convert/record.h"

namespace enfilade::cli {
namespace {

struct MoveCommandOptions {
  std::string link_point;
  std::string map;
  std::string pose;             // X,Y,YAW
  std::string sigma = "0.1,2";  // m, degrees
  bool preview = false;
};

absl::StatusOr<PoseWithCovariance> MeasuredPlace(const MoveCommandOptions& options) {
  const auto pose = ParseNumbers(options.pose, 3);
  if (!pose) return InvalidArgument("--pose is \"{}\": expected X,Y,YAW in metres and radians", options.pose);
  const auto sigma = ParseNumbers(options.sigma, 2);
  if (!sigma || (*sigma)[0] <= 0.0 || (*sigma)[1] <= 0.0) {
    return InvalidArgument("--sigma is \"{}\": expected METRES,DEGREES, both more than 0", options.sigma);
  }
  const double yaw = (*sigma)[1] * kDegree;
  PoseWithCovariance place{{(*pose)[0], (*pose)[1], (*pose)[2]}, Eigen::Matrix3d::Zero()};
  place.covariance.diagonal() << (*sigma)[0] * (*sigma)[0], (*sigma)[0] * (*sigma)[0], yaw * yaw;
  return place;
}

absl::StatusOr<v1::GraphChange> MoveOf(const client::Connection& connection, const Globals& globals,
                                       const MoveCommandOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const PoseWithCovariance place, MeasuredPlace(options));
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, options.map));
  v1::GetLinkPointRequest request;
  request.set_name(ResourceNameOf(globals, "linkPoints", options.link_point));
  ENFILADE_ASSIGN_OR_RETURN(auto response, connection.Call(&v1::LinkPointService::Stub::GetLinkPoint, request));
  v1::GraphChange change;
  change.mutable_update_mask()->add_paths("anchors");
  *change.mutable_updated() = std::move(*response.mutable_link_point());
  auto& anchors = *change.mutable_updated()->mutable_anchors();
  const auto anchor =
      std::find_if(anchors.begin(), anchors.end(), [&](const v1::Anchor& one) { return one.map() == map.name(); });
  if (anchor == anchors.end()) {
    return InvalidArgument("{} has no anchor in {}: add one by enfilade linkpoint set --id {} --at", request.name(),
                           map.name(), IdOf(request.name()));
  }
  *anchor->mutable_pose_map_place() = convert::ToProto(place);
  return change;
}

absl::Status MoveAnchor(const Globals& globals, const MoveCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::GraphChange change, MoveOf(connection, globals, options));
  return RunGraphChanges(globals, connection, {change}, options.preview);
}

absl::Status UndoChange(const Globals& globals, const std::string& entry, bool preview) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<v1::GraphChange> changes,
                            client::ReadInverse(connection, SiteNameOf(globals), entry));
  return RunGraphChanges(globals, connection, changes, preview);
}

}  // namespace

void AddLinkPointChange(CLI::App& linkpoint, const Globals& globals) {
  const auto options = std::make_shared<MoveCommandOptions>();
  CLI::App* move = AddCommand(linkpoint, "move", "Correct where one map sees it: the maps follow",
                              [&globals, options] { return MoveAnchor(globals, *options); });
  move->add_option("LINKPOINT", options->link_point, "Its id or resource name")->required();
  move->add_option("--map", options->map, "The map in which it is moved: name, id or resource name")->required();
  move->add_option("--pose", options->pose, "Its pose in that map: X,Y,YAW in metres and radians")->required();
  move->add_option("--sigma", options->sigma, "How certain that is, standard deviations: METRES,DEGREES")
      ->capture_default_str();
  move->add_flag("--preview", options->preview, kPreviewHelp);
  move->footer("Example: enfilade linkpoint move door-3 --map Hall --pose 12.5,3,0 --sigma 0.02,1 --preview");

  const auto entry = std::make_shared<std::string>();
  const auto preview = std::make_shared<bool>(false);
  CLI::App* undo = AddCommand(linkpoint, "undo", "Take a change of link points back, with all that was changed with it",
                              [&globals, entry, preview] { return UndoChange(globals, *entry, *preview); });
  undo->add_option("ENTRY", *entry, "The id of its entry in enfilade site audit")->required();
  undo->add_flag("--preview", *preview, kPreviewHelp);
  undo->footer("Example: enfilade linkpoint undo 892345678901234567 --preview");
}

}  // namespace enfilade::cli
