// SPDX-License-Identifier: Apache-2.0
// Rooms of floor plans with ground truth, and of simulated drives mapped by SLAM, as JSON on standard output:
//   bench_rooms [--plans DIR] [--coloured FILE]... [--buildings N] [--first-seed S] [--campus NAME]... [--laps N]
//     [--reports] [--sessions] [--list] [--plots DIR] [--candidates FILE] [--lines FILE]
// --plans is a folder with NAME.png, NAME_furnitures.png and NAME_gt_segmentation.png; --coloured are robots' maps
// whose rooms people have coloured (true_plans.h). --candidates writes what is known about each narrow place
// and whether it is a door in truth: fit_door_trees fits the odds of core/rooms to it.

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/cli/commands/offline/rooms_picture.h"
#include "core/base/status_macros.h"
#include "core/rooms/door_lines.h"
#include "core/rooms/passage_silence.h"
#include "core/rooms/region_map.h"
#include "core/rooms/room_partition.h"
#include "core/rooms/surroundings.h"
#include "fmt/format.h"
#include "io/file.h"
#include "tests/bench/rooms/mapped_drive.h"
#include "tests/bench/rooms/true_plans.h"
#include "tests/support/rooms/room_scores.h"

namespace enfilade::bench {
namespace {

struct RoomsBenchOptions {
  std::string plans;
  std::vector<std::string> coloured;
  int buildings = 0;
  std::uint64_t first_seed = 6001;
  std::vector<std::string> campuses;
  std::optional<int> laps;
  bool reports = false;
  bool sessions = false;
  std::string cache;
  std::string plots;
  std::string candidates;
  std::string lines;
  bool list = false;
};

class RoomsBench {
 public:
  explicit RoomsBench(const RoomsBenchOptions& options) : options_(options) {
    if (!options.candidates.empty()) candidates_.open(options.candidates);
    if (!options.lines.empty()) lines_.open(options.lines);
  }

  absl::Status Run() {
    if (!options_.plans.empty()) {
      for (const auto& [key, kind] : {std::pair("empty_plans", ""), std::pair("furnished_plans", "_furnitures")}) {
        ENFILADE_ASSIGN_OR_RETURN(const std::vector<TruePlan> plans, ReadTruePlans(options_.plans, kind));
        ENFILADE_RETURN_IF_ERROR(ScorePlans(key, plans));
      }
    }
    if (!options_.coloured.empty()) {
      std::vector<TruePlan> plans;
      for (const std::string& file : options_.coloured) {
        ENFILADE_ASSIGN_OR_RETURN(plans.emplace_back(), ReadColouredPlan(file));
      }
      ENFILADE_RETURN_IF_ERROR(ScorePlans("robots_maps", plans));
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
  absl::Status ScorePlans(const std::string& key, const std::vector<TruePlan>& plans) {
    testing::PlanScore sum;
    nlohmann::json list = nlohmann::json::array();
    for (const TruePlan& plan : plans) {
      const auto begin = std::chrono::steady_clock::now();
      const rooms::RoomPartition partition = rooms::PartitionRooms(plan.map);
      const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
      const testing::PlanScore score = testing::ScorePlan(partition, plan.rooms);
      ENFILADE_RETURN_IF_ERROR(Plot(plan.name, plan.map, partition));
      const grid::GridGeometry& geometry = plan.map.geometry;
      const auto room_at = [&](const Eigen::Vector2d& p) {
        const int x = static_cast<int>(p.x() / geometry.resolution);
        const int y = static_cast<int>(p.y() / geometry.resolution);
        return geometry.contains(x, y) ? plan.rooms[geometry.index(x, y)] : 0;
      };
      Write(plan.name, plan.map, {}, room_at);
      sum.rooms += score.rooms;
      sum.found += score.found;
      sum.segments += score.segments;
      list.push_back(ToJson(score));
      list.back()["plan"] = plan.name;
      list.back()["seconds"] = seconds.count();
    }
    document_[key] = ToJson(sum);
    if (options_.list) document_[key]["plans"] = list;
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
                                MapDrive(campus, {SeedOf(campus), options_.laps, options_.sessions, options_.cache}));
      std::vector<Eigen::Vector2d> trajectory;
      for (const testing::DrivePoint& point : mapped.drive) trajectory.push_back(point.p_map);
      std::vector<rooms::PassageHint> reported;
      if (options_.reports) reported = mapped.reported;
      const rooms::RoomPartition partition = rooms::PartitionRooms(mapped.grid, {}, {reported, trajectory});
      const testing::DriveScore score = testing::ScoreDrive(partition, mapped.drive, mapped.passages);
      ENFILADE_RETURN_IF_ERROR(Plot(campus, mapped.grid, partition));
      const auto room_at = [&](const Eigen::Vector2d& p_map) {
        const simulator::Area* area = mapped.campus.AreaAt(mapped.level, mapped.T_campus_map * p_map);
        return area == nullptr ? 0 : static_cast<int>(area - mapped.campus.areas.data()) + 1;
      };
      Write(campus, mapped.grid, {reported, trajectory}, room_at);
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
    for (const rooms::DoorLine& line :
         rooms::FindDoorLines(ground, rooms::DistancesToWalls(ground), room_options, rooms::DoorOdds({}))) {
      const auto pixel = [&](const Eigen::Vector2d& cells) {
        return grid::PixelOf(grid.geometry, rooms::ToMap(grid.geometry, cells));
      };
      grid::DrawLine(image, pixel(line.line.a), pixel(line.line.b), line.openness > 0.0 ? grid::kBlue : grid::kRed);
    }
    ENFILADE_ASSIGN_OR_RETURN(const std::string png, grid::EncodePng(image));
    return io::WriteFile(std::filesystem::path(options_.plots) / (name + ".png"), png);
  }

  // The lines along which a map is cut, before silence counts.
  struct ChosenLines {
    rooms::GroundMap ground;
    rooms::DistanceField field;
    std::vector<rooms::DoorLine> lines;
  };

  static ChosenLines Choose(const grid::OccupancyGrid& grid, const rooms::RoomEvidence& known,
                            const rooms::DoorOdds& odds) {
    const rooms::RoomOptions options;
    ChosenLines chosen;
    chosen.ground = rooms::ReadGround(grid, options, known.trajectory);
    chosen.field = rooms::DistancesToWalls(chosen.ground);
    chosen.lines = rooms::FindDoorLines(chosen.ground, chosen.field, options, odds);
    rooms::AddNarrowsOnPath(chosen.ground, grid.geometry, known.trajectory, options, odds, chosen.lines);
    rooms::AddPassages(chosen.ground, grid.geometry, known.passages, options, odds, chosen.lines);
    return chosen;
  }

  // What --candidates and --lines ask for. room_at(p_map) is the true room, 0 none.
  template <typename RoomAt>
  void Write(const std::string& name, const grid::OccupancyGrid& grid, const rooms::RoomEvidence& known,
             RoomAt&& room_at) {
    if (candidates_.is_open()) WriteCandidates(name, grid, known, room_at);
    if (lines_.is_open()) WriteLines(name, grid, known, room_at);
  }

  // A row for each candidate.
  template <typename RoomAt>
  void WriteCandidates(const std::string& name, const grid::OccupancyGrid& grid, const rooms::RoomEvidence& known,
                       RoomAt&& room_at) {
    const rooms::DoorOdds odds(known);
    auto [ground, field, lines] = Choose(grid, known, odds);
    // Those that are taken for no door, too.
    const std::vector<rooms::DoorLine> others =
        rooms::JudgeNarrowsOnPath(ground, grid.geometry, known.trajectory, rooms::RoomOptions(), odds, lines);
    lines.insert(lines.end(), others.begin(), others.end());
    rooms::WeighSilence(grid.geometry, known, odds, lines);
    for (const rooms::DoorLine& line : lines) {
      WriteRow(candidates_, NameAndTruth(name, grid.geometry, line.line, room_at), rooms::ValuesOf(line.evidence));
    }
  }

  // A row for each line that was chosen, with its surroundings.
  template <typename RoomAt>
  void WriteLines(const std::string& name, const grid::OccupancyGrid& grid, const rooms::RoomEvidence& known,
                  RoomAt&& room_at) {
    const rooms::DoorOdds odds(known);
    auto [ground, field, lines] = Choose(grid, known, odds);
    rooms::WeighSilence(grid.geometry, known, odds, lines);
    std::vector<rooms::DoorCandidate> cuts;
    for (const rooms::DoorLine& line : lines) cuts.push_back(line.line);
    const std::vector<rooms::Surroundings> sides =
        rooms::SurroundingsOf(ground, rooms::CutAlong(ground, field, cuts), lines);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      WriteRow(lines_, NameAndTruth(name, grid.geometry, lines[i].line, room_at), rooms::ValuesOf(lines[i], sides[i]));
    }
  }

  static void WriteRow(std::ofstream& file, const std::string& head, std::span<const double> values) {
    file << head;
    for (const double value : values) file << fmt::format(",{:.3f}", value);
    file << '\n';
  }

  template <typename RoomAt>
  static std::string NameAndTruth(const std::string& name, const grid::GridGeometry& geometry,
                                  const rooms::DoorCandidate& line, RoomAt&& room_at) {
    const Eigen::Vector2d a = rooms::ToMap(geometry, line.a);
    const Eigen::Vector2d b = rooms::ToMap(geometry, line.b);
    const Eigen::Vector2d along = (b - a).normalized();
    const Eigen::Vector2d aside(-along.y(), along.x());
    int before = 0;
    int behind = 0;
    for (const double distance : {0.35, 0.5, 0.7}) {
      if (before == 0) before = room_at((a + b) / 2.0 + distance * aside);
      if (behind == 0) behind = room_at((a + b) / 2.0 - distance * aside);
    }
    const int truth = before == 0 || behind == 0 ? -1 : (before != behind ? 1 : 0);
    return fmt::format("{},{},{:.2f},{:.2f},{:.2f},{:.2f}", name, truth, a.x(), a.y(), b.x(), b.y());
  }

  const RoomsBenchOptions& options_;
  nlohmann::json document_;
  std::ofstream candidates_;
  std::ofstream lines_;
};

}  // namespace
}  // namespace enfilade::bench

int main(int argc, char** argv) {
  enfilade::bench::RoomsBenchOptions options;
  CLI::App app("Rooms of plans and of simulated drives");
  app.add_option("--plans", options.plans, "A folder of floor plans with ground truth");
  app.add_option("--coloured", options.coloured, "Robots' maps whose rooms are coloured: gt_colored_NAME.png");
  app.add_option("--buildings", options.buildings, "How many random buildings")->capture_default_str();
  app.add_option("--first-seed", options.first_seed, "Of the first building")->capture_default_str();
  app.add_option("--campus", options.campuses,
                 "A shipped campus, random:SEED, suites:SEED, halls:SEED, or a file (YAML, NAME.building.yaml)");
  app.add_option("--laps", options.laps, "Of each drive, instead of the campus's");
  app.add_flag("--reports", options.reports, "With the passages that the robot's door detector reports");
  app.add_flag("--sessions", options.sessions,
               "Map each way between two reports on its own, and join them as surveys do");
  app.add_option("--cache", options.cache, "Keep the maps of the drives in this folder");
  app.add_option("--plots", options.plots, "Write a PNG of each map into this folder");
  app.add_option("--candidates", options.candidates, "Write the candidates and their truth as CSV");
  app.add_option("--lines", options.lines, "Write the lines that are cut, what surrounds them and their truth as CSV");
  app.add_flag("--list", options.list, "Also the single plans, and the drives that are not exact");
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = enfilade::bench::RoomsBench(options).Run();
  if (status.ok()) return 0;
  std::cerr << "bench_rooms: " << status.message() << '\n';
  return 1;
}
