// SPDX-License-Identifier: Apache-2.0
// How well walls, corners and doors of floor plans are read.
//   bench_plan_import                     # drawn plans: both styles at ten angles, empty and furnished
//   bench_plan_import --buildings DIR     # the levels of Open-RMF's building.yaml files there, against their pictures
//   bench_plan_import --pictures FILE...  # any pictures: the share of their lines that became walls, double walls
// Prints JSON. --plots DIR draws what was read over the pictures; of buildings, true walls green, walls that are none
// red, walls that were missed blue.
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
#include "tests/support/plans/plan_scores.h"

namespace enfilade::bench {
namespace {

using nlohmann::json;

struct PlanImportBenchOptions {
  std::string plots;
  std::string buildings;
  std::vector<std::string> pictures;
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
    } else {
      ENFILADE_RETURN_IF_ERROR(ScoreDrawnPlans());
    }
    std::cout << document_.dump(1) << '\n';
    return absl::OkStatus();
  }

 private:
  absl::Status ScoreDrawnPlans() {
    for (const testing::WallStyle style : {testing::WallStyle::kFilled, testing::WallStyle::kDoubleLine}) {
      for (const bool furniture : {false, true}) {
        for (int turn = 0; turn <= 45; turn += 5) {
          testing::DrawnPlanOptions drawing{
              .style = style, .turn_deg = static_cast<double>(turn), .furniture = furniture};
          if (style == testing::WallStyle::kFilled) drawing.line_px = 1.2;
          const testing::DrawnPlan drawn = testing::DrawPlan(drawing);
          const std::string name = fmt::format("{}{}_{}", style == testing::WallStyle::kFilled ? "filled" : "double",
                                               furniture ? "_furnished" : "", turn);
          ENFILADE_ASSIGN_OR_RETURN(const auto file, Score(name, drawn.png, drawn.truth));
          if (file) ENFILADE_RETURN_IF_ERROR(Plot(name, cli::DrawPlan(file->graph, file->picture)));
        }
      }
    }
    return absl::OkStatus();
  }

  absl::Status ScoreBuildings() {
    ENFILADE_ASSIGN_OR_RETURN(const std::vector<PicturedLevel> levels, FindPicturedLevels(options_.buildings));
    for (const PicturedLevel& level : levels) {
      ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, io::ReadFile(level.picture));
      ENFILADE_ASSIGN_OR_RETURN(const auto file, Score(level.name, bytes, level.truth));
      if (!file) continue;
      const testing::PlanTolerance tolerance = testing::InUnits({}, *level.truth.metres_per_unit);
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
  app.add_option("--pictures", options.pictures, "Pictures of plans")->check(CLI::ExistingFile);
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = enfilade::bench::PlanImportBench(options).Run();
  if (status.ok()) return 0;
  std::cerr << "bench_plan_import: " << status.message() << '\n';
  return 1;
}
