// SPDX-License-Identifier: Apache-2.0
// Time to the optimum of pose graphs: ours beside the plain Ceres formulation, in one process, on every graph found.
//   bench_pose_graph [--data DIR] [--repetitions N] [--json FILE]
// DIR holds the recorded graphs (default $ENFILADE_DATA); two synthetic graphs of 10,000 poses are always there.

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "core/optimize/io/graph_text.h"
#include "core/optimize/solve_pose_graph.h"
#include "fmt/format.h"
#include "tests/bench/support/pose_graph_ceres_example.h"
#include "tests/support/manhattan_graph.h"

namespace enfilade::bench {
namespace {

namespace fs = std::filesystem;

struct NamedGraph {
  std::string name;
  optimize::PoseGraph graph;
};

std::string ShortName(const fs::path& path, const fs::path& data) {
  const std::string name = fs::relative(path, data);
  return name.starts_with("posegraph/") ? name.substr(std::string("posegraph/").size()) : name;
}

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
    absl::StatusOr<optimize::ParsedPoseGraph> parsed = optimize::ParsePoseGraph(text.str(), path);
    if (!parsed.ok()) continue;  // the 3D one
    graphs.push_back({ShortName(path, data), std::move(parsed->graph)});
  }
  return graphs;
}

// What runs of one kind took. Processor time says the same as wall time of an idle machine, as all here run on one
// thread, and hardly suffers from a busy one.
class Timings {
 public:
  void Run(const std::function<void()>& run) {
    const auto wall = std::chrono::steady_clock::now();
    const std::clock_t cpu = std::clock();
    run();
    cpu_.push_back(static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC);
    wall_.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - wall).count());
  }

  double Seconds() const { return Median(wall_); }
  double CpuSeconds() const { return Median(cpu_); }

 private:
  static double Median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  }

  std::vector<double> wall_;
  std::vector<double> cpu_;
};

nlohmann::json Measure(const NamedGraph& named, int repetitions) {
  Timings cold;
  Timings warm;
  Timings plain_ceres;
  optimize::SolveReport ours;
  CeresExampleResult ceres;
  for (int i = 0; i < repetitions; ++i) {  // in turn, so that a busy machine hits all alike
    optimize::PoseGraph graph = named.graph;
    cold.Run([&] { ours = optimize::SolvePoseGraph({}, graph).value(); });
    warm.Run([&] { optimize::SolvePoseGraph({.initialisation = optimize::Initialisation::kNone}, graph).value(); });
    optimize::PoseGraph again = named.graph;
    plain_ceres.Run([&] { ceres = SolveAsCeresExample(again); });
  }
  return {{"graph", named.name},
          {"nodes", named.graph.nodes.size()},
          {"edges", named.graph.edges.size()},
          {"initial_chi2", ours.initial_chi2},
          {"final_chi2", ours.final_chi2},
          {"iterations", ours.iterations},
          {"seconds", cold.Seconds()},
          {"cpu_seconds", cold.CpuSeconds()},
          {"warm_cpu_seconds", warm.CpuSeconds()},
          {"ceres_final_chi2", ceres.final_chi2},
          {"ceres_iterations", ceres.iterations},
          {"ceres_seconds", plain_ceres.Seconds()},
          {"ceres_cpu_seconds", plain_ceres.CpuSeconds()},
          {"ratio", cold.Seconds() / plain_ceres.Seconds()},
          {"cpu_ratio", cold.CpuSeconds() / plain_ceres.CpuSeconds()}};
}

// As a SLAM front end does: a node more at a time, a warm solve after every tenth.
nlohmann::json MeasureGrowth(const optimize::PoseGraph& whole, std::size_t nodes) {
  optimize::PoseGraph growing;
  std::vector<double> seconds;
  for (std::size_t i = 0; i < nodes; ++i) {
    growing.nodes.push_back(whole.nodes[i]);
    if (i > 0) growing.nodes[i].T_world_node = growing.nodes[i - 1].T_world_node * whole.edges[i - 1].T_from_to;
    for (const optimize::PoseGraphEdge& edge : whole.edges) {
      if (std::max(edge.from, edge.to) == static_cast<std::int64_t>(i)) growing.edges.push_back(edge);
    }
    if (i % 10 != 9) continue;
    const std::clock_t start = std::clock();
    optimize::SolvePoseGraph({.initialisation = optimize::Initialisation::kNone}, growing).value();
    seconds.push_back(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  double sum = 0.0;
  for (const double s : seconds) sum += s;
  return {{"nodes", nodes},
          {"solves", seconds.size()},
          {"mean_cpu_seconds", sum / static_cast<double>(seconds.size())},
          {"largest_cpu_seconds", *std::max_element(seconds.begin(), seconds.end())},
          {"last_cpu_seconds", seconds.back()}};
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
  graphs.push_back({"synthetic, 10,000 poses, sparse",
                    testing::MakeManhattanGraph({.nodes = 10'000, .streets = 100, .loops_per_node = 0.5}).graph});
  graphs.push_back({"synthetic, 10,000 poses, dense",
                    testing::MakeManhattanGraph({.nodes = 10'000, .streets = 50, .loops_per_node = 1.0}).graph});
  nlohmann::json document = {{"graphs", nlohmann::json::array()}};
  std::cout << "CPU seconds, medians\n"
            << fmt::format("| {:<48} | {:>5} | {:>5} | {:>14} | {:>7} | {:>7} | {:>14} | {:>7} | {:>5} |\n", "graph",
                           "nodes", "edges", "chi2", "s", "warm s", "Ceres' chi2", "s", "ratio");
  for (const NamedGraph& graph : graphs) {
    const nlohmann::json row = Measure(graph, repetitions);
    std::cout << fmt::format(
                     "| {:<48} | {:>5} | {:>5} | {:>14.9g} | {:>7.4f} | {:>7.4f} | {:>14.9g} | {:>7.4f} | {:>5.3f} |\n",
                     graph.name, graph.graph.nodes.size(), graph.graph.edges.size(), row["final_chi2"].get<double>(),
                     row["cpu_seconds"].get<double>(), row["warm_cpu_seconds"].get<double>(),
                     row["ceres_final_chi2"].get<double>(), row["ceres_cpu_seconds"].get<double>(),
                     row["cpu_ratio"].get<double>())
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
