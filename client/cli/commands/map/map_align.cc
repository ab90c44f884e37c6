// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <iostream>
#include <memory>
#include <string>

#include "client/cli/commands/commands.h"
#include "client/cli/numbers.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/geometry/pose2.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "fmt/format.h"

namespace enfilade::cli {
namespace {

struct AlignCommandOptions {
  std::string map_a;
  std::string map_b;
  std::string guess;
  double radius_m = 0.0;
  double yaw_range_deg = 0.0;
};

absl::StatusOr<v1::AlignMapsRequest> AlignmentOf(const client::Connection& connection, const Globals& globals,
                                                 const AlignCommandOptions& options) {
  v1::AlignMapsRequest request;
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map a, FindMap(connection, globals, options.map_a));
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map b, FindMap(connection, globals, options.map_b));
  request.set_map_a(a.name());
  request.set_map_b(b.name());
  request.set_radius_m(options.radius_m);
  request.set_yaw_range_rad(options.yaw_range_deg * kDegree);
  if (options.guess.empty()) return request;
  const auto guess = ParseNumbers(options.guess, 3);
  if (!guess) return InvalidArgument("--guess is \"{}\": expected X,Y,YAW in metres and radians", options.guess);
  request.mutable_pose_a_b()->set_x((*guess)[0]);
  request.mutable_pose_a_b()->set_y((*guess)[1]);
  request.mutable_pose_a_b()->set_yaw((*guess)[2]);
  return request;
}

nlohmann::json AlignmentToJson(const v1::AlignMapsResponse& found) {
  nlohmann::json json{{"accepted", found.accepted()},
                      {"reason", found.reason()},
                      {"score", found.score()},
                      {"overlap_m2", found.overlap_m2()},
                      {"rival_ratio", found.rival_ratio()}};
  if (!found.has_pose_a_b()) return json;
  json["pose_a_b"] = PoseToJson(found.pose_a_b());
  json["place_a"] = {{"x", found.place_a().x()}, {"y", found.place_a().y()}};
  return json;
}

void PrintAlignment(const v1::AlignMapsResponse& found) {
  std::cout << (found.accepted() ? "fits: " : "not certain: ") << found.reason() << '\n';
  if (!found.has_pose_a_b()) return;
  const v1::Pose2& pose = found.pose_a_b().pose();
  const auto& covariance = found.pose_a_b().covariance();
  const auto sigma = [&](int i) { return covariance.size() == 9 ? std::sqrt(covariance[4 * i]) : 0.0; };
  std::cout << fmt::format("pose of the second map in the first: {:.3f},{:.3f},{:.4f}\n", pose.x(), pose.y(),
                           pose.yaw())
            << fmt::format("standard deviations: {:.3f} m, {:.3f} m, {:.2f} degrees\n", sigma(0), sigma(1),
                           sigma(2) / kDegree)
            << fmt::format("{:.0f} % of the walls match; {:.1f} m2 of ground in both; ", 100.0 * found.score(),
                           found.overlap_m2())
            << (found.rival_ratio() > 0.0 ? fmt::format("fits {:.1f} times as well as elsewhere\n", found.rival_ratio())
                                          : std::string("fits nowhere else\n"))
            << fmt::format("for a link point: {:.2f},{:.2f} in the first map\n", found.place_a().x(),
                           found.place_a().y());
}

absl::Status AlignTwoMaps(const Globals& globals, const AlignCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::AlignMapsRequest request, AlignmentOf(connection, globals, options));
  ENFILADE_ASSIGN_OR_RETURN(const auto found, connection.Call(&v1::GraphService::Stub::AlignMaps, request));
  globals.json ? PrintJson(std::cout, AlignmentToJson(found)) : PrintAlignment(found);
  return absl::OkStatus();
}

}  // namespace

void AddMapAlign(CLI::App& map, const Globals& globals) {
  const auto options = std::make_shared<AlignCommandOptions>();
  CLI::App* align = AddCommand(map, "align", "Find where one map lies in another by the walls that both have seen",
                               [&globals, options] { return AlignTwoMaps(globals, *options); });
  align->add_option("A", options->map_a, "The map that lies still: name, id or resource name")->required();
  align->add_option("B", options->map_b, "The map that is fitted to it")->required();
  align->add_option("--guess", options->guess,
                    "About where B's frame lies in A's: X,Y,YAW in metres and radians (default: as the graph says)");
  align->add_option("--radius", options->radius_m, "How far off the guess may be, metres (default: 5)")
      ->check(CLI::Range(0.0, 20.0));
  align->add_option("--yaw-range", options->yaw_range_deg, "The same of its direction, degrees (default: 29)")
      ->check(CLI::Range(0.0, 180.0));
  align->footer("Example: enfilade map align Hall Lab --guess 12,0,1.57");
}

}  // namespace enfilade::cli
