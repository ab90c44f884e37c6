#include "core/optimize/starts.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "core/optimize/chordal.h"
#include "core/optimize/normal_equations.h"
#include "core/optimize/spanning_tree.h"

namespace enfilade {
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
  add(SpanningTreePoses(graph), false);
  std::stable_sort(starts.begin(), starts.end(), [](const Start& a, const Start& b) { return a.cost < b.cost; });
  return starts;
}

// Whether the yaws can be carried from `a` to `b` with no edge's yaw error passing pi: then they turn equally often
// around every loop. `turn[i]` is what has to be added to b's yaw i, as accumulated along the edges.
bool TurnAlike(const IndexedGraph& graph, const std::vector<Pose2>& a, const std::vector<Pose2>& b) {
  // An edge's error wraps by an integer w; between a and b, w changes by d(to) - d(from) - (e_b - e_a), all in turns,
  // where d is the unwrapped change of yaw. A potential n with n(to) - n(from) = that integer on all edges says yes.
  std::vector<std::vector<std::pair<int, int>>> neighbours(a.size());
  for (const IndexedEdge& edge : graph.edges) {
    const double error_a = EdgeError(a[edge.from], a[edge.to], edge.measurement).z();
    const double error_b = EdgeError(b[edge.from], b[edge.to], edge.measurement).z();
    const double change = (b[edge.to].yaw - a[edge.to].yaw) - (b[edge.from].yaw - a[edge.from].yaw);
    const int turns = static_cast<int>(std::lround((change - (error_b - error_a)) / (2.0 * M_PI)));
    neighbours[edge.from].emplace_back(edge.to, turns);
    neighbours[edge.to].emplace_back(edge.from, -turns);
  }
  std::vector<std::optional<int>> potential(a.size());
  std::vector<int> queue;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!graph.held[i]) continue;
    potential[i] = 0;
    queue.push_back(static_cast<int>(i));
  }
  for (std::size_t head = 0; head < queue.size(); ++head) {
    const int i = queue[head];
    for (const auto& [j, turns] : neighbours[i]) {
      if (potential[j] && *potential[j] != *potential[i] + turns) return false;
      if (potential[j]) continue;
      potential[j] = *potential[i] + turns;
      queue.push_back(j);
    }
  }
  return true;
}

// Whether noise of the stated information explains the cost: chi-squared with that many degrees of freedom, of which
// the mean plus five standard deviations is as good as never passed by chance.
bool ExplainedByNoise(const IndexedGraph& graph, const GraphLayout& layout, double cost) {
  const double freedom = 3.0 * (static_cast<double>(graph.edges.size()) - layout.structure.size);
  return cost <= freedom + 5.0 * std::sqrt(2.0 * std::max(freedom, 0.0));
}

}  // namespace

Minimum MinimizeFromSeveralStarts(const MinimizeOptions& options, const GraphLayout& layout, IndexedGraph& graph) {
  const std::vector<Start> starts = Starts(options, layout, graph);
  const bool chordal_is_least = starts.empty() || starts.front().chordal;
  std::optional<Minimum> least;
  std::vector<std::vector<Pose2>> minima;
  int iterations = 0;
  IndexedGraph attempt = graph;
  for (const Start& start : starts) {
    if (least && chordal_is_least && ExplainedByNoise(graph, layout, least->cost)) break;
    const auto turns_alike = [&](const std::vector<Pose2>& minimum) { return TurnAlike(graph, minimum, start.poses); };
    if (std::any_of(minima.begin(), minima.end(), turns_alike)) continue;
    attempt.poses = start.poses;
    const Minimum minimum = Minimize(options, layout, attempt);
    iterations += minimum.iterations;
    minima.push_back(attempt.poses);
    if (least && least->cost <= minimum.cost) continue;
    least = minimum;
    graph.poses = attempt.poses;
  }
  if (!least) return Minimize(options, layout, graph);
  least->iterations = iterations;
  return *least;
}

}  // namespace enfilade
