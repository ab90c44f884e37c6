// SPDX-License-Identifier: Apache-2.0
// How well walls, corners and doors of floor plans are read.
//   bench_plan_import [--plots DIR]    # drawn plans: both styles at ten angles, empty and furnished
// Prints JSON.
#include <chrono>
#include <filesystem>
#include <iostream>
#include <string>

#include "CLI/CLI.hpp"
#include "client/cli/commands/prior/plan_overlay.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "io/file.h"
#include "nlohmann/json.hpp"
#include "perception/plan/read_plan.h"
#include "tests/support/plans/drawn_plan.h"
#include "tests/support/plans/plan_scores.h"

namespace enfilade::bench {
namespace {

using nlohmann::json;

struct PlanImportBenchOptions {
  std::string plots;
};

json ToJson(const testing::PlanScore& score, double unit) {
  return {{"recall", score.recall}, {"precision", score.precision}, {"median_error", score.median_error * unit}};
}

class PlanImportBench {
 public:
  explicit PlanImportBench(const PlanImportBenchOptions& options) : options_(options) {}

  absl::Status Run() {
    for (const testing::WallStyle style : {testing::WallStyle::kFilled, testing::WallStyle::kDoubleLine}) {
      for (const bool furniture : {false, true}) {
        for (int turn = 0; turn <= 45; turn += 5) {
          testing::DrawnPlanOptions drawing{
              .style = style, .turn_deg = static_cast<double>(turn), .furniture = furniture};
          if (style == testing::WallStyle::kFilled) drawing.line_px = 1.2;
          const testing::DrawnPlan drawn = testing::DrawPlan(drawing);
          const std::string name = fmt::format("{}{}_{}", style == testing::WallStyle::kFilled ? "filled" : "double",
                                               furniture ? "_furnished" : "", turn);
          ENFILADE_RETURN_IF_ERROR(Score(name, drawn.png, drawn.truth));
        }
      }
    }
    std::cout << document_.dump(1) << '\n';
    return absl::OkStatus();
  }

 private:
  absl::Status Score(const std::string& name, const std::string& bytes, const prior::PlanGraph& truth) {
    const auto begin = std::chrono::steady_clock::now();
    const absl::StatusOr<perception::PlanFile> file = perception::DecodePlan(bytes);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    json& result = document_[name];
    if (!file.ok()) {
      result["error"] = std::string(file.status().message());
      return absl::OkStatus();
    }
    const double metres = truth.metres_per_unit.value_or(1.0);
    const testing::PlanTolerance tolerance = testing::InUnits({}, metres);
    result = {{"walls", ToJson(testing::ScoreWalls(file->graph, truth, tolerance), 1)},
              {"corners", ToJson(testing::ScoreCorners(file->graph, truth, tolerance), 1)},
              {"seconds", seconds.count()},
              {"rooms", file->graph.rooms.size()}};
    if (!truth.doors.empty()) result["doors"] = ToJson(testing::ScoreDoors(file->graph, truth, tolerance), 1);
    if (options_.plots.empty()) return absl::OkStatus();
    ENFILADE_ASSIGN_OR_RETURN(const std::string png, grid::EncodePng(cli::DrawPlan(file->graph, file->picture)));
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
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = enfilade::bench::PlanImportBench(options).Run();
  if (status.ok()) return 0;
  std::cerr << "bench_plan_import: " << status.message() << '\n';
  return 1;
}
