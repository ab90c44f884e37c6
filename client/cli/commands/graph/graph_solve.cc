// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/optimize/ceres/ceres_minimize.h"
#include "core/optimize/io/graph_text.h"
#include "core/optimize/minimize.h"
#include "core/optimize/solve_pose_graph.h"
#include "io/file.h"

namespace enfilade::cli {
namespace {

namespace fs = std::filesystem;

const std::map<std::string, optimize::RobustKernel::Type> kKernels = {{"none", optimize::RobustKernel::Type::kNone},
                                                                      {"huber", optimize::RobustKernel::Type::kHuber},
                                                                      {"cauchy", optimize::RobustKernel::Type::kCauchy},
                                                                      {"dcs", optimize::RobustKernel::Type::kDcs}};
const std::map<std::string, optimize::Initialisation> kInitialisations = {
    {"auto", optimize::Initialisation::kAuto},
    {"none", optimize::Initialisation::kNone},
    {"chordal", optimize::Initialisation::kChordal}};
const std::map<std::string, optimize::Minimizer> kBackends = {{"blocks", &optimize::Minimize},
                                                              {"ceres", &optimize::MinimizeWithCeres}};

struct GraphSolveCommandOptions {
  std::string input;
  std::string output;
  std::string kernel = "none";
  std::string initialisation = "auto";
  std::string backend = "blocks";
  bool trust_odometry = false;
  optimize::SolveOptions solve;
};

struct Solved {
  optimize::ParsedPoseGraph parsed;
  optimize::SolveReport report;
  double seconds = 0.0;  // of solving, without reading and writing
};

optimize::GraphFormat FormatOf(const std::string& path, optimize::GraphFormat otherwise) {
  const std::string extension = fs::path(path).extension();
  if (extension == ".g2o") return optimize::GraphFormat::kG2o;
  if (extension == ".graph") return optimize::GraphFormat::kToro;
  return otherwise;
}

absl::Status Write(const Solved& solved, const std::string& path) {
  return io::WriteFile(
      path, optimize::WritePoseGraph(solved.parsed.graph, FormatOf(path, solved.parsed.format), solved.parsed.fixed));
}

const char* NameOf(optimize::GraphFormat format) { return format == optimize::GraphFormat::kG2o ? "g2o" : "TORO"; }

nlohmann::json ToJson(const GraphSolveCommandOptions& options, const Solved& solved) {
  const optimize::SolveReport& report = solved.report;
  nlohmann::json document = {{"file", options.input},
                             {"format", NameOf(solved.parsed.format)},
                             {"nodes", solved.parsed.graph.nodes.size()},
                             {"edges", solved.parsed.graph.edges.size()},
                             {"components", report.components},
                             {"initial_chi2", report.initial_chi2},
                             {"final_chi2", report.final_chi2},
                             {"initial_cost", report.initial_cost},
                             {"final_cost", report.final_cost},
                             {"iterations", report.iterations},
                             {"converged", report.converged},
                             {"seconds", solved.seconds},
                             {"poses_from_edges", solved.parsed.poses_from_edges},
                             {"skipped", solved.parsed.skipped},
                             {"covariances", nlohmann::json::array()}};
  for (const optimize::NodeCovariance& node : report.covariances) {
    const Eigen::Matrix3d& C = node.covariance;
    document["covariances"].push_back(
        {{"node", node.id},
         {"covariance", {{C(0, 0), C(0, 1), C(0, 2)}, {C(1, 0), C(1, 1), C(1, 2)}, {C(2, 0), C(2, 1), C(2, 2)}}}});
  }
  return document;
}

void PrintText(const GraphSolveCommandOptions& options, const Solved& solved) {
  const optimize::ParsedPoseGraph& parsed = solved.parsed;
  const optimize::SolveReport& report = solved.report;
  std::cout << fmt::format("{}: {} nodes, {} edges, {} component{} ({})\n", options.input, parsed.graph.nodes.size(),
                           parsed.graph.edges.size(), report.components, report.components == 1 ? "" : "s",
                           NameOf(parsed.format));
  if (parsed.poses_from_edges)
    std::cout << "no nodes are declared: the initial poses follow a spanning tree of the edges\n";
  for (const auto& [tag, lines] : parsed.skipped) {
    std::cout << fmt::format("skipped {} line{} of the unknown tag {}\n", lines, lines == 1 ? "" : "s", tag);
  }
  std::cout << fmt::format("initial chi2  {:.9g}\nfinal chi2    {:.9g}\n", report.initial_chi2, report.final_chi2);
  if (options.kernel != "none") {
    std::cout << fmt::format("robust cost   {:.9g} -> {:.9g}\n", report.initial_cost, report.final_cost);
  }
  std::cout << fmt::format("iterations    {}{}\nseconds       {:.4f}\n", report.iterations,
                           report.converged ? "" : " (not converged)", solved.seconds);
  for (const optimize::NodeCovariance& node : report.covariances) {
    const Eigen::Vector3d sigma = node.covariance.diagonal().cwiseSqrt();
    std::cout << fmt::format("node {}: sigma {:.6g} m, {:.6g} m, {:.6g} rad\n", node.id, sigma.x(), sigma.y(),
                             sigma.z());
  }
}

absl::Status RunGraphSolve(const Globals& globals, const GraphSolveCommandOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const std::string text, io::ReadFile(options.input));
  Solved solved;
  ENFILADE_ASSIGN_OR_RETURN(solved.parsed, optimize::ParsePoseGraph(text, options.input));
  optimize::SolveOptions solve = options.solve;
  solve.fixed = solved.parsed.fixed;
  solve.kernel.type = kKernels.at(options.kernel);
  solve.initialisation = kInitialisations.at(options.initialisation);
  solve.minimizer = kBackends.at(options.backend);
  for (optimize::PoseGraphEdge& edge : solved.parsed.graph.edges) {
    if (options.trust_odometry && std::abs(edge.to - edge.from) == 1) edge.robust = false;
  }
  const auto start = std::chrono::steady_clock::now();
  ENFILADE_ASSIGN_OR_RETURN(solved.report, optimize::SolvePoseGraph(solve, solved.parsed.graph));
  solved.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!options.output.empty()) ENFILADE_RETURN_IF_ERROR(Write(solved, options.output));
  if (globals.json) {
    PrintJson(std::cout, ToJson(options, solved));
  } else if (!globals.quiet) {
    PrintText(options, solved);
  }
  return absl::OkStatus();
}

}  // namespace

void AddGraphSolve(CLI::App& graph, const Globals& globals) {
  auto options = std::make_shared<GraphSolveCommandOptions>();
  CLI::App* command = AddCommand(graph, "solve", "Find the poses that best fit a pose graph's measurements",
                                 [&globals, options] { return RunGraphSolve(globals, *options); });
  command->add_option("file", options->input, "g2o or TORO text: VERTEX_SE2, EDGE_SE2, FIX; VERTEX2, EDGE2")
      ->required();
  command->add_option("-o,--output", options->output,
                      "Write the solved graph: .g2o or .graph (TORO) sets the format, which is otherwise the input's");
  command->add_option("--robust", options->kernel, "The kernel against wrong edges")
      ->check(CLI::IsMember(&kKernels))
      ->capture_default_str();
  command->add_option("--kernel-width", options->solve.kernel.width, "The kernel's width in standard deviations")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_flag("--trust-odometry", options->trust_odometry,
                    "No kernel on edges between consecutive ids: it applies to loop closures only");
  command
      ->add_option("--init", options->initialisation,
                   "Start from: none (the file's poses), chordal (no poses needed), auto (the best of several)")
      ->check(CLI::IsMember(&kInitialisations))
      ->capture_default_str();
  command->add_option("--backend", options->backend, "The solver: blocks (ours) or ceres")
      ->check(CLI::IsMember(&kBackends))
      ->capture_default_str();
  command->add_option("--max-iterations", options->solve.max_iterations, "Largest number of steps from each start")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_option("--covariance", options->solve.covariance_of, "Print the covariances of these nodes, by id");
  command->footer(
      "Example:\n  enfilade graph solve intel.g2o -o solved.g2o --robust dcs --kernel-width 3 --trust-odometry");
}

}  // namespace enfilade::cli
