// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/prior/prior_locate_files.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "client/cli/output.h"
#include "core/base/status_macros.h"
#include "core/plot/scene.h"
#include "fmt/format.h"

namespace enfilade::cli {
namespace {

constexpr std::size_t kMostModes = 5;
constexpr double kEllipse = 2.4477;     // sqrt of the 95 % quantile of chi squared, two degrees of freedom
constexpr double kEllipseDistance = 3;  // m between ellipses
constexpr std::size_t kDrawnParticles = 2000;
constexpr grid::Rgb kWall{0, 0, 0};
constexpr grid::Rgb kParticle{255, 127, 14};
constexpr grid::Rgb kUncertain{150, 150, 150};

nlohmann::json Rows(const Eigen::MatrixXd& matrix) {
  nlohmann::json rows = nlohmann::json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    nlohmann::json row = nlohmann::json::array();
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) row.push_back(matrix(i, j));
    rows.push_back(row);
  }
  return rows;
}

nlohmann::json StateJson(const prior::PlanField& field, const prior::PlanState& state) {
  const Eigen::Vector2d sheet = field.ToSheet(state.translation());
  return {{"plan_px", {sheet.x(), sheet.y()}},
          {"plan_m", {state.x, state.y}},
          {"yaw", state.yaw},
          {"scale", std::exp(state.log_scale)},
          {"stretch", std::exp(state.log_stretch)},
          {"metres_per_px", field.metres_per_unit() * std::exp(state.log_scale)},
          {"mirrored", state.mirrored}};
}

nlohmann::json ModesJson(const prior::PlanField& field, const std::vector<prior::PlanMode>& modes) {
  nlohmann::json list = nlohmann::json::array();
  for (std::size_t i = 0; i < std::min(modes.size(), kMostModes); ++i) {
    nlohmann::json mode = StateJson(field, modes[i].mean);
    mode["mass"] = modes[i].mass;
    mode["covariance"] = Rows(modes[i].covariance);
    mode["stretch_sigma"] = modes[i].stretch_sigma;
    list.push_back(mode);
  }
  return list;
}

plot::SceneEllipse EllipseOf(const prior::PlanMode& mode, grid::Rgb color) {
  // Metres and plan metres differ by a quarter at most, which a drawing bears.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(mode.covariance.topLeftCorner<2, 2>());
  const Eigen::Vector2d axis = solver.eigenvectors().col(1);
  return {mode.mean.translation(), kEllipse * std::sqrt(solver.eigenvalues().y()),
          kEllipse * std::sqrt(solver.eigenvalues().x()), std::atan2(axis.y(), axis.x()), color};
}

}  // namespace

nlohmann::json LocatedReport(const prior::PlanField& field, const prior::PlanDrive& drive, double seconds) {
  nlohmann::json report = {{"confident", false},
                           {"confident_after_m", nullptr},
                           {"travelled_m", 0.0},
                           {"metres_per_unit", field.metres_per_unit()},
                           {"axis", field.axis()},
                           {"modes", nlohmann::json::array()},
                           {"submaps", nlohmann::json::array()},
                           {"seconds", seconds}};
  for (const prior::PlanPosterior& step : drive.steps) {
    if (step.confident && report["confident_after_m"].is_null()) report["confident_after_m"] = step.travelled;
  }
  if (!drive.steps.empty()) {
    report["confident"] = drive.steps.back().confident;
    report["travelled_m"] = drive.steps.back().travelled;
    report["modes"] = ModesJson(field, drive.steps.back().modes);
  }
  for (const prior::TrackedSubmap& tracked : drive.submaps) {
    nlohmann::json submap = StateJson(field, tracked.state);
    submap["submap"] = tracked.submap;
    submap["accepted"] = tracked.accepted;
    submap["matched"] = tracked.matched;
    submap["information"] = Rows(tracked.information);
    report["submaps"].push_back(submap);
  }
  return report;
}

nlohmann::json LocatedSteps(const prior::PlanField& field, const prior::PlanDrive& drive,
                            const std::vector<TimeNs>& times) {
  nlohmann::json steps = nlohmann::json::array();
  for (std::size_t i = 0; i < drive.steps.size() && i < times.size(); ++i) {
    const prior::PlanPosterior& step = drive.steps[i];
    steps.push_back({{"time_ns", times[i]},
                     {"travelled_m", step.travelled},
                     {"particles", step.particles},
                     {"effective", step.effective},
                     {"matched", step.matched},
                     {"confident", step.confident},
                     {"modes", ModesJson(field, step.modes)}});
  }
  return steps;
}

std::string DescribeLocated(const prior::PlanField& field, const prior::PlanDrive& drive, double seconds) {
  if (drive.steps.empty() || drive.steps.back().modes.empty()) return "the robot has not driven far enough\n";
  const prior::PlanPosterior& last = drive.steps.back();
  const prior::PlanMode& best = last.modes.front();
  const Eigen::Vector2d sheet = field.ToSheet(best.mean.translation());
  const auto first =
      std::find_if(drive.steps.begin(), drive.steps.end(), [](const auto& one) { return one.confident; });
  std::string text = fmt::format(
      "{} after {:.1f} m: at {:.1f}, {:.1f} px, yaw {:.1f} deg{}, {:.5g} m per unit; {:.0f} % "
      "of the mass, sigma {:.2f} m; {} modes; {}\n",
      last.confident ? "located" : "not certain", last.travelled, sheet.x(), sheet.y(), best.mean.yaw / kDegree,
      best.mean.mirrored ? ", mirrored" : "", field.metres_per_unit() * std::exp(best.mean.log_scale), 100 * best.mass,
      std::sqrt(best.covariance.topLeftCorner<2, 2>().trace()), last.modes.size(), FormatSeconds(seconds));
  if (first != drive.steps.end()) text += fmt::format("certain for the first time after {:.1f} m\n", first->travelled);
  return text;
}

absl::StatusOr<std::string> PlotLocated(const prior::PlanField& field, const prior::PlanDrive& drive) {
  plot::Scene scene;
  for (const prior::WallFace& face : field.faces()) scene.lines.push_back({{face.from, face.to}, kWall});
  const std::size_t every = std::max<std::size_t>(1, drive.particles.size() / kDrawnParticles);
  for (std::size_t i = 0; i < drive.particles.size(); i += every) {
    scene.markers.push_back({drive.particles[i].state.translation(), plot::SceneMarker::Shape::kDot, kParticle});
  }
  double drawn = -kEllipseDistance;
  const prior::PlanPosterior* last = nullptr;
  for (const prior::PlanPosterior& step : drive.steps) {
    if (step.modes.empty()) continue;
    const grid::Rgb color = step.confident ? grid::kGreen : kUncertain;
    const prior::PlanMode& mode = step.modes.front();
    if (last != nullptr) {
      scene.lines.push_back({{last->modes.front().mean.translation(), mode.mean.translation()}, color, 2});
    }
    last = &step;
    if (step.travelled - drawn < kEllipseDistance) continue;
    drawn = step.travelled;
    scene.ellipses.push_back(EllipseOf(mode, color));
  }
  if (last != nullptr) {
    for (std::size_t i = 0; i < std::min(last->modes.size(), kMostModes); ++i) {
      scene.ellipses.push_back(EllipseOf(last->modes[i], grid::kRed));
    }
  }
  ENFILADE_ASSIGN_OR_RETURN(const plot::SceneView view, plot::ViewOf(scene, 1600));
  return grid::EncodePng(plot::DrawScene(scene, view));
}

}  // namespace enfilade::cli
