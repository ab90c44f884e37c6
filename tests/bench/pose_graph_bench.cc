// Time to the optimum of pose graphs: ours beside the plain Ceres formulation, in one process, on every graph found.
//   bench_pose_graph [--data DIR] [--repetitions N] [--json FILE]
// DIR holds the recorded graphs (default $ENFILADE_DATA); a synthetic graph of 10,000 poses is always there.

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "core/optimize/graph_text.h"
#include "core/optimize/solve_pose_graph.h"
#include "fmt/format.h"
#include "tests/bench/pose_graph_ceres_example.h"
#include "tests/support/manhattan_graph.h"

namespace enfilade::bench {
namespace {

namespace fs = std::filesystem;

struct NamedGraph {
  std::string name;
  PoseGraph graph;
};

std::vector<NamedGraph> RecordedGraphs(const fs::path& data) {
  std::vector<fs::path> paths;
  if (fs::exists(data / "posegraph")) {
    for (const auto& entry : fs::recursive_directory_iterator(data / "posegraph")) {
      if (entry.path().extension() == ".g2o") paths.push_back(entry.path());
    }
  }
  if (fs::exists(data / "laser/flirtlib/intel-lab.log")) paths.push_back(data / "laser/flirtlib/intel-lab.log");
  std::sort(paths.begin(), paths.end());
  std::vector<NamedGraph> graphs;
  for (const fs::path& path : paths) {
    std::stringstream text;
    text << std::ifstream(path).rdbuf();
    absl::StatusOr<ParsedPoseGraph> parsed = ParsePoseGraph(text.str(), path);
    if (!parsed.ok()) continue;  // the 3D one
    graphs.push_back({fs::relative(path, data), std::move(parsed->graph)});
  }
  return graphs;
}

// Seconds of the median run; `run` gets a fresh copy of the graph each time, made outside of the measured time.
double MedianSeconds(const PoseGraph& graph, int repetitions, const std::function<void(PoseGraph&)>& run) {
  std::vector<double> seconds;
  for (int i = 0; i < repetitions; ++i) {
    PoseGraph copy = graph;
    const auto start = std::chrono::steady_clock::now();
    run(copy);
    seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  std::nth_element(seconds.begin(), seconds.begin() + repetitions / 2, seconds.end());
  return seconds[repetitions / 2];
}

nlohmann::json Measure(const NamedGraph& named, int repetitions) {
  SolveReport ours;
  PoseGraph solved;
  const double our_seconds = MedianSeconds(named.graph, repetitions, [&](PoseGraph& graph) {
    ours = SolvePoseGraph({}, graph).value();
    solved = graph;
  });
  const double warm_seconds = MedianSeconds(solved, repetitions, [&](PoseGraph& graph) {
    SolvePoseGraph({.initialisation = Initialisation::kNone}, graph).value();
  });
  CeresExampleResult ceres;
  const double ceres_seconds =
      MedianSeconds(named.graph, repetitions, [&](PoseGraph& graph) { ceres = SolveAsCeresExample(graph); });
  return {{"graph", named.name},
          {"nodes", named.graph.nodes.size()},
          {"edges", named.graph.edges.size()},
          {"initial_chi2", ours.initial_chi2},
          {"final_chi2", ours.final_chi2},
          {"iterations", ours.iterations},
          {"seconds", our_seconds},
          {"warm_seconds", warm_seconds},
          {"ceres_final_chi2", ceres.final_chi2},
          {"ceres_iterations", ceres.iterations},
          {"ceres_seconds", ceres_seconds},
          {"ratio", our_seconds / ceres_seconds}};
}

// As a SLAM front end does: a node more at a time, a warm solve after every tenth.
nlohmann::json MeasureGrowth(const PoseGraph& whole, std::size_t nodes) {
  PoseGraph growing;
  std::vector<double> seconds;
  for (std::size_t i = 0; i < nodes; ++i) {
    growing.nodes.push_back(whole.nodes[i]);
    if (i > 0) growing.nodes[i].T_world_node = growing.nodes[i - 1].T_world_node * whole.edges[i - 1].T_from_to;
    for (const PoseGraphEdge& edge : whole.edges) {
      if (std::max(edge.from, edge.to) == static_cast<std::int64_t>(i)) growing.edges.push_back(edge);
    }
    if (i % 10 != 9) continue;
    const auto start = std::chrono::steady_clock::now();
    SolvePoseGraph({.initialisation = Initialisation::kNone}, growing).value();
    seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  double sum = 0.0;
  for (const double s : seconds) sum += s;
  return {{"nodes", nodes},
          {"solves", seconds.size()},
          {"mean_seconds", sum / static_cast<double>(seconds.size())},
          {"largest_seconds", *std::max_element(seconds.begin(), seconds.end())},
          {"last_seconds", seconds.back()}};
}

int Main(int argc, char** argv) {
  const char* environment = std::getenv("ENFILADE_DATA");
  std::string data = environment ? environment : "";
  std::string json_path;
  int repetitions = 7;
  CLI::App app("Pose graphs: ours beside plain Ceres");
  app.add_option("--data", data, "The recordings' folder");
  app.add_option("--repetitions", repetitions, "Of which the median is taken")->check(CLI::PositiveNumber);
  app.add_option("--json", json_path, "Also write the figures there");
  CLI11_PARSE(app, argc, argv);

  std::vector<NamedGraph> graphs = RecordedGraphs(data);
  graphs.push_back({"synthetic, 10,000 poses",
                    testing::MakeManhattanGraph({.nodes = 10'000, .streets = 50, .loops_per_node = 1.0}).graph});
  nlohmann::json document = {{"graphs", nlohmann::json::array()}};
  std::cout << fmt::format("| {:<67} | {:>6} | {:>6} | {:>14} | {:>8} | {:>8} | {:>14} | {:>8} | {:>6} |\n", "graph",
                           "nodes", "edges", "chi2", "s", "warm s", "Ceres' chi2", "s", "ratio");
  for (const NamedGraph& graph : graphs) {
    const nlohmann::json row = Measure(graph, repetitions);
    std::cout << fmt::format(
                     "| {:<67} | {:>6} | {:>6} | {:>14.9g} | {:>8.4f} | {:>8.4f} | {:>14.9g} | {:>8.4f} | {:>6.3f} |\n",
                     graph.name, graph.graph.nodes.size(), graph.graph.edges.size(), row["final_chi2"].get<double>(),
                     row["seconds"].get<double>(), row["warm_seconds"].get<double>(),
                     row["ceres_final_chi2"].get<double>(), row["ceres_seconds"].get<double>(),
                     row["ratio"].get<double>())
              << std::flush;
    document["graphs"].push_back(row);
  }
  const nlohmann::json growth = MeasureGrowth(graphs.back().graph, 3000);
  std::cout << "growing to 3000 nodes, a warm solve after every tenth: " << growth.dump() << '\n';
  document["growth"] = growth;
  if (!json_path.empty()) std::ofstream(json_path) << document.dump(2) << '\n';
  return 0;
}

}  // namespace
}  // namespace enfilade::bench

int main(int argc, char** argv) { return enfilade::bench::Main(argc, argv); }
