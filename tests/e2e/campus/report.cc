// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/campus/report.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "fmt/format.h"
#include "fmt/ranges.h"

namespace enfilade::testing {
namespace {

constexpr double kDegrees = 180.0 / M_PI;

// The counts of a comparison, by the names that the JSON uses.
constexpr std::pair<const char*, int Comparison::*> kCounts[] = {
    {"areas", &Comparison::areas},
    {"maps", &Comparison::maps},
    {"areas_doubled", &Comparison::areas_doubled},
    {"areas_missing", &Comparison::areas_missing},
    {"maps_merged", &Comparison::maps_merged},
    {"maps_extra", &Comparison::maps_extra},
    {"doors", &Comparison::doors},
    {"joins", &Comparison::joins},
    {"doors_doubled", &Comparison::doors_doubled},
    {"doors_missing", &Comparison::doors_missing},
    {"joins_wrong", &Comparison::joins_wrong},
    {"joins_false", &Comparison::joins_false},
    {"candidates", &Comparison::candidates},
    {"components", &Comparison::components},
    {"passages", &Comparison::passages},
    {"stretches", &Comparison::stretches},
    {"false_placements", &Comparison::false_placements},
};

double MedianOf(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0.0 : values[values.size() / 2];
}

double Percent(int part, int whole) { return whole > 0 ? 100.0 * part / whole : 0.0; }

// What is measured, by the names that the JSON uses.
std::vector<std::pair<const char*, Consistency>> KindsOf(const Consistency& poses, const GraphConsistency& graph) {
  return {{"poses", poses}, {"joins", graph.joins}, {"chains", graph.chains}, {"maps", graph.maps}};
}

std::string ConsistencyOf(const Consistency& poses, const GraphConsistency& graph) {
  std::vector<std::string> parts;
  for (const auto& [name, kind] : KindsOf(poses, graph)) {
    parts.push_back(fmt::format("{} {:.1f} % of {}, {:.2f}, {:.3f} m", name, 100.0 * kind.inside_share(), kind.samples,
                                kind.mean_nees(), kind.rms()));
  }
  return fmt::format("{}", fmt::join(parts, "; "));
}

nlohmann::json ToJson(const Consistency& poses, const GraphConsistency& graph) {
  nlohmann::json document;
  for (const auto& [name, kind] : KindsOf(poses, graph)) {
    document[name] = {
        {"samples", kind.samples}, {"inside", kind.inside}, {"mean_nees", kind.mean_nees()}, {"rms_m", kind.rms()}};
  }
  return document;
}

}  // namespace

void CampusTotals::Add(const CampusResult& result) {
  ++runs;
  exact += result.comparison.exact ? 1 : 0;
  for (const auto& [name, count] : kCounts) sums.*count += result.comparison.*count;
  sums.unplaced_s += result.comparison.unplaced_s;
  sums.unmapped_s += result.comparison.unmapped_s;
  sums.position_max = std::max(sums.position_max, result.comparison.position_max);
  poses.Add(result.poses);
  graph.joins.Add(result.graph.joins);
  graph.chains.Add(result.graph.chains);
  graph.maps.Add(result.graph.maps);
  if (!result.has_last_poses) return;
  errors.push_back(result.final_error);
  yaw_errors.push_back(result.final_yaw_error * kDegrees);
}

std::string CampusHeader() {
  return fmt::format(
      "{:<20} {:>4} {:>5}  {:>10} {:>2} {:>2} {:>2}  {:>10} {:>2} {:>2} {:>2} {:>2}  {:>3} {:>6}  {:>6} {:>6} {:>5}  "
      "{:>7} {:>7}  {}",
      "campus", "seed", "exact", "areas/maps", "d", "m", "x", "doors/join", "d", "m", "w", "f", "pcs", "false", "rms m",
      "end m", "deg", "inside", "seconds", "wrong");
}

std::string CampusLine(const CampusRun& run, const CampusResult& result) {
  const Comparison& c = result.comparison;
  std::string line = fmt::format(
      "{:<20} {:>4} {:>5}  {:>10} {:>2} {:>2} {:>2}  {:>10} {:>2} {:>2} {:>2} {:>2}  {:>3} {:>6}  {:>6.3f} {:>6.3f} "
      "{:>5.2f}  {:>7} {:>7.1f}  {}",
      CampusNameOf(run.campus), run.seed, c.exact ? "yes" : "no", fmt::format("{}/{}", c.areas, c.maps),
      c.areas_doubled, c.areas_missing, c.maps_extra, fmt::format("{}/{}", c.doors, c.joins), c.doors_doubled,
      c.doors_missing, c.joins_wrong, c.joins_false, c.components,
      fmt::format("{}/{}", c.false_placements, c.stretches), c.position_rms, result.final_error,
      result.final_yaw_error * kDegrees, fmt::format("{}/{}", result.poses.inside, result.poses.samples),
      result.seconds, fmt::join(c.wrong, "; "));
  line.erase(line.find_last_not_of(' ') + 1);
  return line;
}

std::string Summary(const CampusTotals& totals) {
  const Comparison& c = totals.sums;
  return fmt::format(
      "{} of {} graphs exact ({:.0f} %){}; {} pieces in all\n"
      "areas: {} entered, {} maps; {} doubled ({:.1f} %), {} without a map of their own ({:.1f} %), {} maps too many\n"
      "doors: {} passed, {} joins; {} missing ({:.1f} %), {} doubled, {} joins of wrong maps, {} joins at no door\n"
      "false placements: {} of {} stretches ({} passages); {:.1f} s without a place, {:.1f} s not mapped\n"
      "final pose error: median {:.3f} m, {:.2f} deg\n"
      "truth inside the 95 % ellipsoid, mean NEES (1 if right), error: {}",
      totals.exact, totals.runs, 100.0 * totals.exact_share(),
      totals.failed > 0 ? fmt::format(", {} FAILED", totals.failed) : "", c.components, c.areas, c.maps,
      c.areas_doubled, Percent(c.areas_doubled, c.areas), c.areas_missing, Percent(c.areas_missing, c.areas),
      c.maps_extra, c.doors, c.joins, c.doors_missing, Percent(c.doors_missing, c.doors), c.doors_doubled,
      c.joins_wrong, c.joins_false, c.false_placements, c.stretches, c.passages, c.unplaced_s, c.unmapped_s,
      MedianOf(totals.errors), MedianOf(totals.yaw_errors), ConsistencyOf(totals.poses, totals.graph));
}

nlohmann::json ToJson(const CampusRun& run, const CampusResult& result) {
  const Comparison& c = result.comparison;
  nlohmann::json document = {{"campus", run.campus},
                             {"seed", run.seed},
                             {"robots", result.robots},
                             {"laps", run.laps},
                             {"site", result.site},
                             {"exact", c.exact},
                             {"wrong", c.wrong},
                             {"unplaced_s", c.unplaced_s},
                             {"unmapped_s", c.unmapped_s},
                             {"position_rms_m", c.position_rms},
                             {"position_max_m", c.position_max},
                             {"yaw_max_deg", c.yaw_max * kDegrees},
                             {"has_last_poses", result.has_last_poses},
                             {"final_error_m", result.final_error},
                             {"final_yaw_error_deg", result.final_yaw_error * kDegrees},
                             {"consistency", ToJson(result.poses, result.graph)},
                             {"seconds", result.seconds},
                             {"verdicts", result.verdicts}};
  for (const auto& [name, count] : kCounts) document[name] = c.*count;
  return document;
}

nlohmann::json ToJson(const CampusTotals& totals) {
  nlohmann::json document = {{"runs", totals.runs},
                             {"failed", totals.failed},
                             {"exact", totals.exact},
                             {"exact_share", totals.exact_share()},
                             {"unplaced_s", totals.sums.unplaced_s},
                             {"unmapped_s", totals.sums.unmapped_s},
                             {"position_max_m", totals.sums.position_max},
                             {"median_final_error_m", MedianOf(totals.errors)},
                             {"median_final_yaw_error_deg", MedianOf(totals.yaw_errors)},
                             {"consistency", ToJson(totals.poses, totals.graph)}};
  for (const auto& [name, count] : kCounts) document[name] = totals.sums.*count;
  return document;
}

std::string LogHeader() {
  return fmt::format(
      "{:<28} {:>4}  {:>4} {:>5} {:>4} {:>3}  {:>8} {:>8}  {:>6} {:>8}  {:>8} {:>8} {:>6} {:>8}  {:>7} {:>7}"
      "  {:>6} {:>2} {:>2} {:>2}  {}",
      "log", "seed", "maps", "joins", "cand", "pcs", "passages", "sessions", "poses", "left out", "error m", "slam m",
      "ratio", "differ m", "seconds", "slam s", "areas", "d", "m", "x", "wrong");
}

std::string LogLine(const LogRun& run, const LogResult& result) {
  const auto metres = [](const std::optional<TrajectoryError>& error) {
    return error && error->used > 0 ? fmt::format("{:.3f}", error->metres) : std::string("-");
  };
  std::string line = fmt::format(
      "{:<28} {:>4}  {:>4} {:>5} {:>4} {:>3}  {:>8} {:>8}  {:>6} {:>8}  {:>8} {:>8} {:>6} {:>8}  {:>7.1f} {:>7.1f}",
      run.log.filename().string(), run.seed, result.maps, result.joins, result.candidates, result.components,
      result.passages, result.sessions, result.poses, result.left_out, metres(result.error), metres(result.slam_error),
      result.ratio() ? fmt::format("{:.2f}", *result.ratio()) : "-", metres(result.difference), result.seconds,
      result.slam_seconds);
  if (result.rooms) {
    line += fmt::format("  {:>6} {:>2} {:>2} {:>2}  {}", result.rooms->areas, result.rooms->areas_doubled,
                        result.rooms->areas_missing, result.rooms->maps_extra, fmt::join(result.rooms->wrong, "; "));
  }
  return line;
}

nlohmann::json ToJson(const LogRun& run, const LogResult& result) {
  const auto error = [](const std::optional<TrajectoryError>& measured) {
    if (!measured || measured->used == 0) return nlohmann::json();
    return nlohmann::json{{"metres", measured->metres},
                          {"degrees", measured->degrees},
                          {"used", measured->used},
                          {"skipped", measured->skipped}};
  };
  const auto rooms = [&]() -> nlohmann::json {
    if (!result.rooms) return nullptr;
    return {{"areas", result.rooms->areas},
            {"areas_doubled", result.rooms->areas_doubled},
            {"areas_missing", result.rooms->areas_missing},
            {"maps_merged", result.rooms->maps_merged},
            {"maps_extra", result.rooms->maps_extra},
            {"wrong", result.rooms->wrong}};
  };
  return {{"log", run.log.string()},
          {"seed", run.seed},
          {"simulated_odometry", run.simulate_odometry},
          {"site", result.site},
          {"maps", result.maps},
          {"joins", result.joins},
          {"candidates", result.candidates},
          {"components", result.components},
          {"passages", result.passages},
          {"sessions", result.sessions},
          {"poses", result.poses},
          {"left_out", result.left_out},
          {"error", error(result.error)},
          {"slam_error", error(result.slam_error)},
          {"ratio", result.ratio() ? nlohmann::json(*result.ratio()) : nlohmann::json()},
          {"difference", error(result.difference)},
          {"rooms", rooms()},
          {"seconds", result.seconds},
          {"slam_seconds", result.slam_seconds},
          {"verdicts", result.verdicts}};
}

}  // namespace enfilade::testing
