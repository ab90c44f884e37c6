// SPDX-License-Identifier: Apache-2.0
// How well walls, corners and doors of floor plans are read.
//   bench_plan_import                     # drawn plans: both styles at ten angles, empty, furnished, with dimensions
//   bench_plan_import --buildings DIR     # the levels of Open-RMF's building.yaml files there, against their pictures
//   bench_plan_import --pictures FILE...  # any pictures: the share of their lines that became walls, double walls
//   bench_plan_import --photos            # drawn plans as a camera sees them on a table, beside the plans themselves
// The truth of some buildings runs along faces of thick walls: walls_to_faces counts a line anywhere within a wall that
// was read as that wall.
// Prints JSON. --plots DIR draws what was read over the pictures; of buildings, true walls green, walls that are none
// red, walls that were missed blue.
#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "client/cli/commands/prior/plan_overlay.h"
#include "core/base/status_macros.h"
#include "core/prior/plan/planar.h"
#include "fmt/format.h"
#include "io/file.h"
#include "nlohmann/json.hpp"
#include "perception/plan/read_plan.h"
#include "tests/bench/support/plan_truth.h"
#include "tests/support/plans/drawn_plan.h"
#include "tests/support/plans/photo.h"
#include "tests/support/plans/plan_scores.h"

namespace enfilade::bench {
namespace {

using nlohmann::json;

struct PlanImportBenchOptions {
  std::string plots;
  std::string buildings;
  std::vector<std::string> pictures;
  bool photos = false;
};

// median_error: in pixels.
json ToJson(const testing::PlanScore& score) {
  return {{"recall", score.recall}, {"precision", score.precision}, {"median_error", score.median_error}};
}

class PlanImportBench {
 public:
  explicit PlanImportBench(const PlanImportBenchOptions& options) : options_(options) {}

  absl::Status Run() {
    if (!options_.buildings.empty()) {
      ENFILADE_RETURN_IF_ERROR(ScoreBuildings());
    } else if (!options_.pictures.empty()) {
      for (const std::string& picture : options_.pictures) ENFILADE_RETURN_IF_ERROR(JudgePicture(picture));
    } else if (options_.photos) {
      ENFILADE_RETURN_IF_ERROR(ScorePhotos());
    } else {
      ENFILADE_RETURN_IF_ERROR(ScoreDrawnPlans());
    }
    std::cout << document_.dump(1) << '\n';
    return absl::OkStatus();
  }

 private:
  absl::Status ScoreDrawnPlans() {
    for (const testing::WallStyle style : {testing::WallStyle::kFilled, testing::WallStyle::kDoubleLine}) {
      for (const std::string contents : {"", "_furnished", "_dimensions"}) {
        for (int turn = 0; turn <= 45; turn += 5) {
          testing::DrawnPlanOptions drawing{.style = style,
                                            .turn_deg = static_cast<double>(turn),
                                            .furniture = contents == "_furnished",
                                            .dimensions = contents == "_dimensions",
                                            .plot = contents == "_dimensions"};
          if (style == testing::WallStyle::kFilled) drawing.line_px = 1.2;
          const testing::DrawnPlan drawn = testing::DrawPlan(drawing);
          const std::string name =
              fmt::format("{}{}_{}", style == testing::WallStyle::kFilled ? "filled" : "double", contents, turn);
          ENFILADE_ASSIGN_OR_RETURN(const auto file, Score(name, drawn.png, drawn.truth));
          if (file) ENFILADE_RETURN_IF_ERROR(Plot(name, cli::DrawPlan(file->graph, file->picture)));
        }
      }
    }
    return absl::OkStatus();
  }

  absl::Status ScorePhotos() {
    for (const testing::WallStyle style : {testing::WallStyle::kFilled, testing::WallStyle::kDoubleLine}) {
      const testing::DrawnPlan drawn =
          testing::DrawPlan({.style = style, .px_per_m = 50, .line_px = 3, .furniture = true});
      const std::string name = style == testing::WallStyle::kFilled ? "filled" : "double";
      ENFILADE_RETURN_IF_ERROR(Score(name, drawn.png, drawn.truth).status());
      std::uint32_t seed = 1;
      for (const double tilt : {0.0, 10.0, 20.0, 30.0, 40.0}) {
        for (const double pan : {-25.0, 0.0, 15.0}) {
          const testing::Photo photo =
              testing::TakePhoto(drawn.png, {.tilt_deg = tilt, .pan_deg = pan, .seed = seed++});
          ENFILADE_RETURN_IF_ERROR(ScorePhoto(fmt::format("{} {} {}", name, tilt, pan), photo, drawn));
        }
      }
    }
    return absl::OkStatus();
  }

  absl::Status ScorePhoto(const std::string& name, const testing::Photo& photo, const testing::DrawnPlan& drawn) {
    json ignored;
    const absl::StatusOr<perception::PlanFile> file = Read(photo.png, ignored);
    if (!options_.plots.empty()) {
      ENFILADE_RETURN_IF_ERROR(io::WriteFile(std::filesystem::path(options_.plots) / (name + " photo.png"), photo.png));
    }
    document_[name]["rectified"] = file.ok() && file->graph.H_sheet_photo.has_value();
    if (!document_[name]["rectified"]) return absl::OkStatus();
    const Eigen::Matrix3d H = *file->graph.H_sheet_photo * photo.H_photo_sheet;
    const auto moved = [&](double x, double y) -> Eigen::Vector2d {
      return (H * Eigen::Vector3d(x, y, 1)).eval().hnormalized();
    };
    prior::PlanGraph truth = drawn.truth;
    for (prior::PlanCorner& corner : truth.corners) corner.point = moved(corner.point.x(), corner.point.y());
    for (prior::PlanDoor& door : truth.doors) {
      door.from = moved(door.from.x(), door.from.y());
      door.to = moved(door.to.x(), door.to.y());
    }
    const double width = (moved(drawn.width, 0) - moved(0, 0)).norm() / drawn.width;
    const double height = (moved(0, drawn.height) - moved(0, 0)).norm() / drawn.height;
    truth.metres_per_unit = *drawn.truth.metres_per_unit / std::sqrt(width * height);
    ENFILADE_ASSIGN_OR_RETURN(const auto scored, Score(name, photo.png, truth));
    document_[name]["rectified"] = true;
    document_[name]["aspect_error"] = width / height - 1;
    return scored ? Plot(name, cli::DrawPlan(scored->graph, scored->picture)) : absl::OkStatus();
  }

  absl::Status ScoreBuildings() {
    ENFILADE_ASSIGN_OR_RETURN(const std::vector<PicturedLevel> levels, FindPicturedLevels(options_.buildings));
    for (const PicturedLevel& level : levels) {
      ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, io::ReadFile(level.picture));
      ENFILADE_ASSIGN_OR_RETURN(const auto file, Score(level.name, bytes, level.truth));
      if (!file) continue;
      const testing::PlanTolerance tolerance = testing::InUnits({}, *level.truth.metres_per_unit);
      testing::PlanTolerance to_faces = tolerance;
      to_faces.within_thickness = true;
      document_[level.name]["walls_to_faces"] = ToJson(testing::ScoreWalls(file->graph, level.truth, to_faces));
      document_[level.name]["drawn"] = ShareDrawn(level.truth, *file->picture, tolerance);
      ENFILADE_RETURN_IF_ERROR(Plot(level.name, DrawDifferences(*file, level.truth, tolerance)));
    }
    return absl::OkStatus();
  }

  absl::Status JudgePicture(const std::string& path) {
    ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, io::ReadFile(path));
    json& result = document_[path];
    const absl::StatusOr<perception::PlanFile> file = Read(bytes, result);
    if (!file.ok()) return absl::OkStatus();
    // Two lines nearer to each other than 0.7 % of the sheet's diagonal (0.35 m in a building of 50 m) are one wall.
    constexpr double kReachShare = 0.007;
    const double diagonal = std::hypot(file->picture->width, file->picture->height);
    ENFILADE_ASSIGN_OR_RETURN(result["strokes"], ShareOfStrokes(bytes, file->graph));
    result["double_walls"] = testing::ShareOfDoubleWalls(file->graph, 2, kReachShare * diagonal);
    result["planar"] = prior::IsPlanar(file->graph);
    result["rectified"] = file->graph.H_sheet_photo.has_value();
    result["walls"] = file->graph.walls.size();
    result["doors"] = file->graph.doors.size();
    result["megapixels"] = 1e-6 * file->picture->width * file->picture->height;
    std::string name = path;
    std::replace(name.begin(), name.end(), '/', '_');
    return Plot(name, cli::DrawPlan(file->graph, file->picture));
  }

  // nullopt: it was refused, as the result says.
  absl::StatusOr<std::optional<perception::PlanFile>> Score(const std::string& name, const std::string& bytes,
                                                            const prior::PlanGraph& truth) {
    json& result = document_[name];
    absl::StatusOr<perception::PlanFile> file = Read(bytes, result);
    if (!file.ok()) return std::nullopt;
    const testing::PlanTolerance tolerance = testing::InUnits({}, truth.metres_per_unit.value_or(1.0));
    result["walls"] = ToJson(testing::ScoreWalls(file->graph, truth, tolerance));
    result["corners"] = ToJson(testing::ScoreCorners(file->graph, truth, tolerance));
    if (!truth.doors.empty()) result["doors"] = ToJson(testing::ScoreDoors(file->graph, truth, tolerance));
    result["rooms"] = file->graph.rooms.size();
    return std::optional(*std::move(file));
  }

  static absl::StatusOr<perception::PlanFile> Read(const std::string& bytes, json& result) {
    const auto begin = std::chrono::steady_clock::now();
    absl::StatusOr<perception::PlanFile> file = perception::DecodePlan(bytes);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    result["seconds"] = seconds.count();
    if (!file.ok()) result["error"] = std::string(file.status().message());
    return file;
  }

  absl::Status Plot(const std::string& name, const grid::RgbImage& image) const {
    if (options_.plots.empty()) return absl::OkStatus();
    ENFILADE_ASSIGN_OR_RETURN(const std::string png, grid::EncodePng(image));
    return io::WriteFile(std::filesystem::path(options_.plots) / (name + ".png"), png);
  }

  const PlanImportBenchOptions& options_;
  json document_;
};

}  // namespace
}  // namespace enfilade::bench

int main(int argc, char** argv) {
  enfilade::bench::PlanImportBenchOptions options;
  CLI::App app("Walls, corners and doors of floor plans");
  app.add_option("--plots", options.plots, "Write a PNG of each plan into this folder");
  app.add_option("--buildings", options.buildings, "A folder of building.yaml files and their pictures")
      ->check(CLI::ExistingDirectory);
  app.add_flag("--photos", options.photos, "Photos of drawn plans");
  app.add_option("--pictures", options.pictures, "Pictures of plans")->check(CLI::ExistingFile);
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = enfilade::bench::PlanImportBench(options).Run();
  if (status.ok()) return 0;
  std::cerr << "bench_plan_import: " << status.message() << '\n';
  return 1;
}
