// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <cmath>
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/files/rgb_image.h"
#include "io/file.h"
#include "perception/cloud/decode_cloud.h"
#include "perception/cloud/draw_clouds.h"
#include "perception/cloud/registration.h"

namespace enfilade::cli {
namespace {

using perception::RegistrationMethod;

const std::map<std::string, RegistrationMethod> kMethods = {{"icp", RegistrationMethod::kIcp},
                                                            {"gicp", RegistrationMethod::kGicp}};

struct MatchCloudsCommandOptions {
  std::string source;
  std::string target;
  std::string output;
  std::vector<double> guess;  // x y z yaw
  std::string method = "gicp";
  bool not_turned = false;
  perception::RegistrationOptions registration;
};

absl::StatusOr<perception::Cloud> LoadCloud(const std::string& path) {
  ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, io::ReadFile(path));
  absl::StatusOr<perception::Cloud> cloud = perception::DecodeCloud(bytes);
  if (!cloud.ok()) return WithContext(cloud.status(), path);
  return cloud;
}

Eigen::Isometry3d GuessOf(const std::vector<double>& numbers) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  if (numbers.size() != 4) return T;
  T.linear() = Eigen::AngleAxisd(numbers[3], Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() = Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
  return T;
}

template <typename Matrix>
nlohmann::json RowByRow(const Matrix& matrix) {
  nlohmann::json numbers = nlohmann::json::array();
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) numbers.push_back(matrix(row, column));
  }
  return numbers;
}

nlohmann::json ToJson(const MatchCloudsCommandOptions& options, const perception::Registration& found, double seconds) {
  const Pose2 pose = perception::PlanarPose(found).pose;
  return {{"source", options.source},
          {"target", options.target},
          {"accepted", found.accepted},
          {"fitness", found.fitness},
          {"inlier_share", found.inlier_share},
          {"T_target_source", RowByRow(found.T_target_source.matrix())},
          {"pose", {{"x", pose.x}, {"y", pose.y}, {"yaw", pose.yaw}}},
          {"covariance", RowByRow(found.covariance)},
          {"converged", found.converged},
          {"turned", found.turned},
          {"iterations", found.iterations},
          {"overlap", found.overlap},
          {"reason", found.reason},
          {"seconds", seconds}};
}

void PrintCloudMatch(const perception::Registration& found) {
  const PoseWithCovariance planar = perception::PlanarPose(found);
  const Eigen::Vector3d sigma = planar.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  std::cout << fmt::format("{}: {}{}\n", found.accepted ? "the same place" : "not recognised as the same place",
                           found.reason, found.turned ? " (turned by 180 degrees)" : "");
  std::cout << fmt::format("inlier share  {:.3f}\nfitness       {:.4f} m^2\niterations    {}{}\n", found.inlier_share,
                           found.fitness, found.iterations, found.converged ? "" : " (not converged)");
  std::cout << fmt::format("pose          x {:.3f} m, y {:.3f} m, yaw {:.4f} rad (sigma {:.4f}, {:.4f}, {:.5f})\n",
                           planar.pose.x, planar.pose.y, planar.pose.yaw, sigma.x(), sigma.y(), sigma.z());
  std::cout << "T_target_source\n";
  for (int row = 0; row < 4; ++row) {
    const Eigen::RowVector4d values = found.T_target_source.matrix().row(row);
    std::cout << fmt::format("  {:10.6f} {:10.6f} {:10.6f} {:10.6f}\n", values[0], values[1], values[2], values[3]);
  }
}

absl::Status RunMatchClouds(const Globals& globals, const MatchCloudsCommandOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const perception::Cloud source, LoadCloud(options.source));
  ENFILADE_ASSIGN_OR_RETURN(const perception::Cloud target, LoadCloud(options.target));
  perception::RegistrationOptions registration = options.registration;
  registration.method = kMethods.at(options.method);
  registration.try_turned = !options.not_turned;
  const auto start = std::chrono::steady_clock::now();
  ENFILADE_ASSIGN_OR_RETURN(const perception::Registration found,
                            perception::RegisterClouds(source, target, GuessOf(options.guess), registration));
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!options.output.empty()) {
    const grid::RgbImage picture = perception::DrawClouds(source, target, found.T_target_source);
    ENFILADE_ASSIGN_OR_RETURN(const std::string png, grid::EncodePng(picture));
    ENFILADE_RETURN_IF_ERROR(io::WriteFile(options.output, png));
  }
  if (globals.json) {
    PrintJson(std::cout, ToJson(options, found, seconds));
  } else if (!globals.quiet) {
    PrintCloudMatch(found);
    if (!options.output.empty()) std::cout << "picture       " << options.output << '\n';
  }
  return absl::OkStatus();
}

}  // namespace

void AddMatchClouds(CLI::App& match, const Globals& globals) {
  auto options = std::make_shared<MatchCloudsCommandOptions>();
  CLI::App* command = AddCommand(match, "clouds", "Find the pose of one point cloud in another's frame, by ICP or GICP",
                                 [&globals, options] { return RunMatchClouds(globals, *options); });
  command->add_option("SOURCE", options->source, "PCD or PLY")->required();
  command->add_option("TARGET", options->target, "PCD or PLY")->required();
  command->add_option("-o,--output", options->output, "Draw both from above into a PNG: target blue, source red");
  command->add_option("--guess", options->guess, "Initial guess of the source's pose: x y z (m) yaw (rad)")
      ->expected(4);
  command->add_flag("--not-turned", options->not_turned, "Do not also start from the guess turned by 180 degrees");
  command->add_option("--method", options->method, "icp (point to point) or gicp (plane to plane)")
      ->check(CLI::IsMember(&kMethods))
      ->capture_default_str();
  command->add_option("--voxel", options->registration.voxel, "Voxel size that both clouds are downsampled to, m")
      ->capture_default_str();
  command
      ->add_option("--max-distance", options->registration.max_distance,
                   "Largest distance of corresponding points at the start, m")
      ->capture_default_str();
  command
      ->add_option("--min-inlier-share", options->registration.min_inlier_share,
                   "Reject matches with a smaller inlier share")
      ->capture_default_str();
  command->add_option("--max-fitness", options->registration.max_fitness, "Reject matches with a larger fitness, m^2")
      ->capture_default_str();
  command->footer("Example:\n  enfilade match clouds now.pcd then.pcd --guess 0.5 0 0 3.14 -o both.png");
}

}  // namespace enfilade::cli
