// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/initialization/starts.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "core/optimize/initialization/chordal.h"
#include "core/optimize/initialization/spanning_tree.h"
#include "core/optimize/linear/normal_equations.h"

namespace enfilade::optimize {
namespace {

struct Start {
  std::vector<Pose2> poses;
  double cost = 0.0;
  bool chordal = false;
};

std::vector<Start> Starts(const MinimizeOptions& options, const GraphLayout& layout, const IndexedGraph& graph) {
  std::vector<Start> starts;
  const auto add = [&](std::vector<Pose2> poses, bool chordal) {
    const double cost = GraphCost(graph, poses, options.kernel);
    if (std::isfinite(cost)) starts.push_back({std::move(poses), cost, chordal});
  };
  if (std::optional<std::vector<Pose2>> chordal = ChordalPoses(graph, layout)) add(*std::move(chordal), true);
  add(graph.poses, false);
  // One wrong edge in a spanning tree misplaces every node behind it.
  if (options.kernel.type == RobustKernel::Type::kNone) add(SpanningTreePoses(graph), false);
  std::stable_sort(starts.begin(), starts.end(), [](const Start& a, const Start& b) { return a.cost < b.cost; });
  return starts;
}

// For one edge: by how many more whole turns its yaw error is wrapped at poses `b` than at poses `a`. The turns also
// depend on how the yaws are written (yaw or yaw + 2 pi); around a loop that cancels out.
struct EdgeTurns {
  int from = 0;
  int to = 0;
  int turns = 0;
};

// For the edges with a kernel weight of at least one half at `a`. The turns of edges taken for wrong do not matter.
std::vector<EdgeTurns> TurnsBetween(const IndexedGraph& graph, const RobustKernel& kernel, const std::vector<Pose2>& a,
                                    const std::vector<Pose2>& b) {
  std::vector<EdgeTurns> all;
  for (const IndexedEdge& edge : graph.edges) {
    const Eigen::Vector3d error_a = EdgeError(a[edge.from], a[edge.to], edge.measurement);
    if (edge.robust && Evaluate(kernel, error_a.dot(edge.information * error_a)).weight < 0.5) continue;
    const double error_b = EdgeError(b[edge.from], b[edge.to], edge.measurement).z();
    const double change = (b[edge.to].yaw - a[edge.to].yaw) - (b[edge.from].yaw - a[edge.from].yaw);
    const double turns = (change - (error_b - error_a.z())) / (2.0 * M_PI);
    all.push_back({edge.from, edge.to, static_cast<int>(std::lround(turns))});
  }
  return all;
}

// Whether the yaws turn equally often around every loop: the yaws can then be moved from one set of poses to the other
// without any edge's yaw error passing pi, and the edges' turns are differences of whole turns of the nodes.
bool HaveEqualWinding(const std::vector<EdgeTurns>& edges, std::size_t nodes) {
  std::vector<std::vector<std::pair<int, int>>> neighbours(nodes);
  for (const EdgeTurns& edge : edges) {
    neighbours[edge.from].emplace_back(edge.to, edge.turns);
    neighbours[edge.to].emplace_back(edge.from, -edge.turns);
  }
  std::vector<std::optional<int>> node_turns(nodes);
  for (std::size_t root = 0; root < nodes; ++root) {
    if (node_turns[root]) continue;
    node_turns[root] = 0;
    std::vector<int> queue = {static_cast<int>(root)};
    while (!queue.empty()) {
      const int i = queue.back();
      queue.pop_back();
      for (const auto& [j, turns] : neighbours[i]) {
        if (!node_turns[j]) queue.push_back(j);
        if (!node_turns[j]) node_turns[j] = *node_turns[i] + turns;
        if (*node_turns[j] != *node_turns[i] + turns) return false;
      }
    }
  }
  return true;
}

// Whether noise of the stated information explains the cost. The cost is then chi-squared with `freedom` degrees of
// freedom: mean `freedom`, variance 2 `freedom`. Chance hardly ever exceeds the mean by five standard deviations.
bool ExplainedByNoise(const IndexedGraph& graph, const GraphLayout& layout, double cost) {
  const double freedom = 3.0 * (static_cast<double>(graph.edges.size()) - layout.structure.size);
  return cost <= freedom + 5.0 * std::sqrt(2.0 * std::max(freedom, 0.0));
}

Minimum LeastOfSeveralStarts(Minimizer minimize, const MinimizeOptions& options, const GraphLayout& layout,
                             IndexedGraph& graph) {
  const std::vector<Start> starts = Starts(options, layout, graph);
  const bool chordal_is_least = starts.empty() || starts.front().chordal;
  std::optional<Minimum> least;
  std::vector<std::vector<Pose2>> minima;
  int iterations = 0;
  IndexedGraph attempt = graph;
  for (const Start& start : starts) {
    if (least && chordal_is_least && ExplainedByNoise(graph, layout, least->cost)) break;
    const auto has_equal_winding = [&](const std::vector<Pose2>& minimum) {
      return HaveEqualWinding(TurnsBetween(graph, options.kernel, minimum, start.poses), graph.poses.size());
    };
    if (std::any_of(minima.begin(), minima.end(), has_equal_winding)) continue;
    attempt.poses = start.poses;
    const Minimum minimum = minimize(options, layout, attempt);
    iterations += minimum.iterations;
    minima.push_back(attempt.poses);
    if (least && least->cost <= minimum.cost) continue;
    least = minimum;
    graph.poses = attempt.poses;
  }
  if (!least) return minimize(options, layout, graph);
  least->iterations = iterations;
  return *least;
}

bool HasManyMinima(const RobustKernel& kernel) {
  return kernel.type == RobustKernel::Type::kCauchy || kernel.type == RobustKernel::Type::kDcs;
}

}  // namespace

Minimum MinimizeFromSeveralStarts(Minimizer minimize, const MinimizeOptions& options, const GraphLayout& layout,
                                  IndexedGraph& graph) {
  if (!HasManyMinima(options.kernel)) return LeastOfSeveralStarts(minimize, options, layout, graph);
  MinimizeOptions coarse = options;
  coarse.relative_tolerance = std::max(options.relative_tolerance, 1e-2);
  coarse.kernel.width = 10.0 * options.kernel.width;
  int iterations = LeastOfSeveralStarts(minimize, coarse, layout, graph).iterations;
  coarse.kernel.width = 3.0 * options.kernel.width;
  iterations += minimize(coarse, layout, graph).iterations;
  Minimum minimum = minimize(options, layout, graph);
  minimum.iterations += iterations;
  return minimum;
}

}  // namespace enfilade::optimize
