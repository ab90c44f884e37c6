// SPDX-License-Identifier: Apache-2.0
// Rooms of floor plans with ground truth, and of simulated drives mapped by SLAM, as JSON on standard output:
//   bench_rooms [--plans DIR] [--buildings N] [--first-seed S] [--campus NAME]... [--laps N] [--reports] [--list]
//     [--plots DIR] [--candidates FILE]
// PLANS is a folder with NAME.png, NAME_furnitures.png and NAME_gt_segmentation.png. --candidates writes what is known
// about each narrow place and whether it is a door in truth: fit_door_trees fits the odds of core/rooms to it.

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/commands/offline/rooms_picture.h"
#include "core/base/status_macros.h"
#include "core/grid/files/plan_image.h"
#include "core/rooms/door_lines.h"
#include "core/rooms/passage_silence.h"
#include "core/rooms/room_partition.h"
#include "fmt/format.h"
#include "io/file.h"
#include "tests/bench/support/mapped_drive.h"
#include "tests/support/room_scores.h"

namespace enfilade::bench {
namespace {

struct RoomsBenchOptions {
  std::string plans;
  int buildings = 0;
  std::uint64_t first_seed = 6001;
  std::vector<std::string> campuses;
  std::optional<int> laps;
  bool reports = false;
  std::string cache;
  std::string plots;
  std::string candidates;
  bool list = false;
};

class RoomsBench {
 public:
  explicit RoomsBench(const RoomsBenchOptions& options) : options_(options) {
    if (!options.candidates.empty()) candidates_.open(options.candidates);
  }

  absl::Status Run() {
    if (!options_.plans.empty()) {
      for (const char* kind : {"", "_furnitures"}) ENFILADE_RETURN_IF_ERROR(ScorePlans(kind));
    }
    std::vector<std::string> buildings;
    for (int i = 0; i < options_.buildings; ++i) {
      buildings.push_back(fmt::format("random:{}", options_.first_seed + static_cast<std::uint64_t>(i)));
    }
    if (!buildings.empty()) ENFILADE_RETURN_IF_ERROR(ScoreDrives("random_buildings", buildings));
    if (!options_.campuses.empty()) ENFILADE_RETURN_IF_ERROR(ScoreDrives("campuses", options_.campuses));
    std::cout << document_.dump(2) << '\n';
    return absl::OkStatus();
  }

 private:
  absl::Status ScorePlans(const std::string& kind) {
    const std::string truth_suffix = "_gt_segmentation.png";
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(options_.plans)) {
      const std::string name = entry.path().filename().string();
      if (name.ends_with(truth_suffix)) names.push_back(name.substr(0, name.size() - truth_suffix.size()));
    }
    std::sort(names.begin(), names.end());
    testing::PlanScore sum;
    nlohmann::json list = nlohmann::json::array();
    for (const std::string& name : names) {
      const std::filesystem::path folder(options_.plans);
      ENFILADE_ASSIGN_OR_RETURN(const grid::OccupancyGrid plan, ReadPlan(folder / (name + kind + ".png")));
      ENFILADE_ASSIGN_OR_RETURN(const grid::OccupancyGrid truth, ReadPlan(folder / (name + truth_suffix)));
      const auto begin = std::chrono::steady_clock::now();
      const rooms::RoomPartition partition = rooms::PartitionRooms(plan);
      const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
      const testing::PlanScore score = testing::ScorePlan(partition, truth);
      ENFILADE_RETURN_IF_ERROR(Plot(name + kind, plan, partition));
      if (candidates_.is_open()) {
        const std::vector<int> pieces = testing::RoomsOfTruth(truth);
        WriteCandidates(name + kind, plan, {}, [&](const Eigen::Vector2d& p) {
          const int x = static_cast<int>(p.x() / truth.geometry.resolution);
          const int y = static_cast<int>(p.y() / truth.geometry.resolution);
          return truth.geometry.contains(x, y) ? pieces[truth.geometry.index(x, y)] : 0;
        });
      }
      sum.rooms += score.rooms;
      sum.found += score.found;
      sum.segments += score.segments;
      list.push_back(ToJson(score));
      list.back()["plan"] = name + kind;
      list.back()["seconds"] = seconds.count();
    }
    nlohmann::json& result = document_[kind.empty() ? "empty_plans" : "furnished_plans"];
    result = ToJson(sum);
    if (options_.list) result["plans"] = list;
    return absl::OkStatus();
  }

  absl::Status ScoreDrives(const std::string& key, const std::vector<std::string>& campuses) {
    int exact = 0;
    int areas = 0;
    int doubled = 0;
    int merged = 0;
    int passages = 0;
    int missed = 0;
    int false_changes = 0;
    nlohmann::json list = nlohmann::json::array();
    for (const std::string& campus : campuses) {
      ENFILADE_ASSIGN_OR_RETURN(const MappedDrive mapped,
                                MapDrive(campus, {SeedOf(campus), options_.laps, options_.cache}));
      std::vector<Eigen::Vector2d> trajectory;
      for (const testing::DrivePoint& point : mapped.drive) trajectory.push_back(point.p_map);
      std::vector<rooms::PassageHint> reported;
      if (options_.reports) reported = mapped.reported;
      const rooms::RoomPartition partition = rooms::PartitionRooms(mapped.grid, {}, {reported, trajectory});
      const testing::DriveScore score = testing::ScoreDrive(partition, mapped.drive, mapped.passages);
      ENFILADE_RETURN_IF_ERROR(Plot(campus, mapped.grid, partition));
      if (candidates_.is_open()) {
        WriteCandidates(campus, mapped.grid, {reported, trajectory}, [&](const Eigen::Vector2d& p_map) {
          const simulator::Area* area = mapped.campus.AreaAt(mapped.level, mapped.T_campus_map * p_map);
          return area == nullptr ? 0 : static_cast<int>(area - mapped.campus.areas.data()) + 1;
        });
      }
      exact += score.exact() ? 1 : 0;
      areas += score.areas;
      doubled += score.doubled;
      merged += score.merged;
      passages += static_cast<int>(mapped.passages.size());
      missed += score.missed;
      false_changes += score.false_changes;
      if (!score.exact()) list.push_back({{"campus", campus}, {"faults", score.faults}});
    }
    document_[key] = {{"campuses", campuses.size()},
                      {"exact", exact},
                      {"areas", areas},
                      {"doubled", doubled},
                      {"merged", merged},
                      {"passages", passages},
                      {"missed", missed},
                      {"false_changes", false_changes}};
    if (options_.list) document_[key]["not_exact"] = list;
    return absl::OkStatus();
  }

  static std::uint64_t SeedOf(const std::string& campus) {
    const std::size_t colon = campus.find(':');
    return colon == std::string::npos ? 1 : std::stoull(campus.substr(colon + 1));
  }

  static absl::StatusOr<grid::OccupancyGrid> ReadPlan(const std::filesystem::path& path) {
    ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, io::ReadFile(path));
    return grid::ReadPlan(bytes);
  }

  static nlohmann::json ToJson(const testing::PlanScore& score) {
    return {{"rooms", score.rooms},
            {"found", score.found},
            {"found_share", score.rooms > 0 ? static_cast<double>(score.found) / score.rooms : 0.0},
            {"segments", score.segments},
            {"extra", score.extra()}};
  }

  absl::Status Plot(const std::string& name, const grid::OccupancyGrid& grid, const rooms::RoomPartition& partition) {
    if (options_.plots.empty()) return absl::OkStatus();
    // Narrow places that are no doors are blue.
    grid::RgbImage image = cli::DrawRooms(grid, partition);
    const rooms::RoomOptions room_options;
    const rooms::GroundMap ground = rooms::ReadGround(grid, room_options, {});
    for (const rooms::DoorLine& line : rooms::FindDoorLines(ground, rooms::DistancesToWalls(ground), room_options)) {
      const auto pixel = [&](const Eigen::Vector2d& cells) {
        return grid::PixelOf(grid.geometry, rooms::ToMap(grid.geometry, cells));
      };
      grid::DrawLine(image, pixel(line.line.a), pixel(line.line.b), line.openness > 0.0 ? grid::kBlue : grid::kRed);
    }
    ENFILADE_ASSIGN_OR_RETURN(const std::string png, grid::EncodePng(image));
    return io::WriteFile(std::filesystem::path(options_.plots) / (name + ".png"), png);
  }

  // A line for each candidate of which the truth is known: room_at(p_map) is the true room, 0 none.
  template <typename RoomAt>
  void WriteCandidates(const std::string& name, const grid::OccupancyGrid& grid, const rooms::RoomEvidence& known,
                       RoomAt&& room_at) {
    const rooms::RoomOptions options;
    const rooms::GroundMap ground = rooms::ReadGround(grid, options, known.trajectory);
    const rooms::DistanceField field = rooms::DistancesToWalls(ground);
    std::vector<rooms::DoorLine> lines = rooms::FindDoorLines(ground, field, options);
    rooms::AddNarrowsOnPath(ground, grid.geometry, known.trajectory, options, lines);
    rooms::AddPassages(ground, grid.geometry, known.passages, lines);
    // Those that are taken for no door, too.
    const std::vector<rooms::DoorLine> others =
        rooms::JudgeNarrowsOnPath(ground, grid.geometry, known.trajectory, options, lines);
    lines.insert(lines.end(), others.begin(), others.end());
    rooms::WeighSilence(grid.geometry, known, lines);
    for (const rooms::DoorLine& line : lines) {
      const Eigen::Vector2d a = rooms::ToMap(grid.geometry, line.line.a);
      const Eigen::Vector2d b = rooms::ToMap(grid.geometry, line.line.b);
      const Eigen::Vector2d along = (b - a).normalized();
      const Eigen::Vector2d aside(-along.y(), along.x());
      int before = 0;
      int behind = 0;
      for (const double distance : {0.35, 0.5, 0.7}) {
        if (before == 0) before = room_at((a + b) / 2.0 + distance * aside);
        if (behind == 0) behind = room_at((a + b) / 2.0 - distance * aside);
      }
      const int truth = before == 0 || behind == 0 ? -1 : (before != behind ? 1 : 0);
      candidates_ << fmt::format("{},{},{:.2f},{:.2f},{:.2f},{:.2f}", name, truth, a.x(), a.y(), b.x(), b.y());
      for (const double value : rooms::ValuesOf(line.evidence)) candidates_ << fmt::format(",{:.3f}", value);
      candidates_ << fmt::format(",{:.3f}\n", line.openness);
    }
  }

  const RoomsBenchOptions& options_;
  nlohmann::json document_;
  std::ofstream candidates_;
};

}  // namespace
}  // namespace enfilade::bench

int main(int argc, char** argv) {
  enfilade::bench::RoomsBenchOptions options;
  CLI::App app("Rooms of plans and of simulated drives");
  app.add_option("--plans", options.plans, "A folder of floor plans with ground truth");
  app.add_option("--buildings", options.buildings, "How many random buildings")->capture_default_str();
  app.add_option("--first-seed", options.first_seed, "Of the first building")->capture_default_str();
  app.add_option("--campus", options.campuses, "A shipped campus, or random:SEED");
  app.add_option("--laps", options.laps, "Of each drive, instead of the campus's");
  app.add_flag("--reports", options.reports, "With the passages that the robot's door detector reports");
  app.add_option("--cache", options.cache, "Keep the maps of the drives in this folder");
  app.add_option("--plots", options.plots, "Write a PNG of each map into this folder");
  app.add_option("--candidates", options.candidates, "Write the narrow places and their truth as CSV");
  app.add_flag("--list", options.list, "Also the single plans, and the drives that are not exact");
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = enfilade::bench::RoomsBench(options).Run();
  if (status.ok()) return 0;
  std::cerr << "bench_rooms: " << status.message() << '\n';
  return 1;
}
