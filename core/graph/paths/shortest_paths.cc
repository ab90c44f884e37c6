// SPDX-License-Identifier: Apache-2.0
#include "core/graph/paths/shortest_paths.h"

#include <algorithm>
#include <cmath>
#include <queue>

#include "core/graph/paths/leg_cost.h"

namespace enfilade::graph {
namespace {

using Doorway = GraphSnapshot::Doorway;

// An entry of the heap.
struct Entry {
  double cost = 0.0;
  int hops = 0;
  int link_point = 0;
};
struct Later {
  bool operator()(const Entry& a, const Entry& b) const { return a.cost != b.cost ? a.cost > b.cost : a.hops > b.hops; }
};

// The cheapest entrance into a map so far. If legs are sums of the costs of their ends, a more expensive entrance leads
// nowhere more cheaply.
struct Entrance {
  double cost = std::numeric_limits<double>::infinity();
  int hops = 0;
  int link_point = -1;
};

// The best path to a target so far.
struct ReachedTarget {
  PathTarget target;
  double cost = std::numeric_limits<double>::infinity();
};

bool MayPass(const GraphSnapshot::LinkPointNode& node, const PathOptions& options) {
  if (!options.passable_at.has_value() || node.state == PassageState::kOpen) return true;
  return node.state_valid_until.has_value() && *options.passable_at >= *node.state_valid_until;
}

template <PathCost kCost>
class Search {
 public:
  Search(const GraphSnapshot& graph, const std::vector<PathSource>& sources, const PathOptions& options,
         const std::vector<PathTarget>& targets)
      : graph_(graph),
        sources_(sources),
        options_(options),
        labels_(graph.link_point_slots()),
        is_source_(graph.map_slots()),
        entrances_(kLegsAreSums<kCost> ? graph.map_slots() : 0) {
    for (const PathSource& source : sources_) is_source_[static_cast<std::size_t>(source.map)] = 1;
    for (const PathTarget& target : targets) targets_.push_back({.target = target});
    std::sort(targets_.begin(), targets_.end(),
              [](const auto& a, const auto& b) { return a.target.map < b.target.map; });
  }

  std::vector<PathLabel> Run() {
    for (int i = 0; i < static_cast<int>(sources_.size()); ++i) StartAt(i);
    while (!heap_.empty()) {
      const Entry entry = heap_.top();
      heap_.pop();
      const PathLabel& label = labels_[static_cast<std::size_t>(entry.link_point)];
      if (entry.cost != label.cost || entry.hops != label.hops) continue;  // a better path was found since
      if (entry.cost > bound_) break;
      Settle(entry, label.map, label.source);
    }
    return std::move(labels_);
  }

 private:
  void StartAt(int source_index) {
    const PathSource& source = sources_[static_cast<std::size_t>(source_index)];
    for (const Doorway& doorway : graph_.map_node(source.map).doorways) {
      if (options_.without_first_legs != nullptr &&
          options_.without_first_legs->contains(LegKey(source.map, doorway.link_point))) {
        continue;
      }
      Relax(doorway.link_point, {.cost = FirstLegCost<kCost>(source, doorway, lever_squared_),
                                 .hops = 1,
                                 .previous = -1,
                                 .map = source.map,
                                 .source = source_index});
    }
  }

  void Settle(const Entry& entry, int arrival_map, int source) {
    for (const int map : graph_.link_point_node(entry.link_point).maps) {
      if (!MayEnter(map, arrival_map)) continue;
      if constexpr (kLegsAreSums<kCost>) {
        if (entrances_[static_cast<std::size_t>(map)].link_point != entry.link_point) continue;
      }
      const Doorway& here = DoorwayOf(graph_, map, entry.link_point);
      for (const Doorway& doorway : graph_.map_node(map).doorways) {
        if (doorway.link_point == entry.link_point) continue;
        Relax(doorway.link_point, {.cost = CostAcross<kCost>(entry.cost, here, doorway, lever_squared_),
                                   .hops = entry.hops + 1,
                                   .previous = entry.link_point,
                                   .map = map,
                                   .source = source});
      }
    }
  }

  bool MayEnter(int map, int from) const {
    if (map == from || is_source_[static_cast<std::size_t>(map)] != 0) return false;
    return options_.without_maps == nullptr || !options_.without_maps->contains(map);
  }

  void Relax(int link_point, const PathLabel& label) {
    PathLabel& current = labels_[static_cast<std::size_t>(link_point)];
    if (label.cost > current.cost) return;
    if (label.cost == current.cost) {
      if (label.hops > current.hops) return;
      if (label.hops == current.hops && !IsPreferred(label, current)) return;
    }
    if (options_.without_link_points != nullptr && options_.without_link_points->contains(link_point)) return;
    const bool is_better = label.cost < current.cost || label.hops < current.hops;
    current = label;
    if (Continues(link_point, label, is_better)) {
      heap_.push({.cost = label.cost, .hops = label.hops, .link_point = link_point});
    }
  }

  // Whether a map behind the link point may be worth entering by it. If legs are sums, only a map with no cheaper known
  // entrance is: each map is then crossed about once instead of from each of its doorways.
  bool Continues(int link_point, const PathLabel& label, bool is_better) {
    const GraphSnapshot::LinkPointNode& node = graph_.link_point_node(link_point);
    if (!MayPass(node, options_)) return false;
    bool continues = false;
    for (std::size_t i = 0; i < node.maps.size(); ++i) {
      const int map = node.maps[i];
      if (!MayEnter(map, label.map)) continue;
      if (!targets_.empty()) Reach(map, link_point, label.cost);
      if constexpr (kLegsAreSums<kCost>) {
        const double end = EndCost<kCost>(node.link_point->anchors[i].covariance, lever_squared_);
        const Entrance entrance{.cost = label.cost + end, .hops = label.hops, .link_point = link_point};
        Entrance& best = entrances_[static_cast<std::size_t>(map)];
        if (!IsBetter(entrance, best)) continue;
        best = entrance;
        continues = true;
      } else {
        continues = is_better;
      }
    }
    return continues;
  }

  // Notes what a target in the map costs by the link point. The search goes on as long as any target may get cheaper.
  void Reach(int map, int link_point, double cost) {
    const auto found = std::lower_bound(targets_.begin(), targets_.end(), map,
                                        [](const ReachedTarget& one, int slot) { return one.target.map < slot; });
    if (found == targets_.end() || found->target.map != map) return;
    cost += LastLegCost<kCost>(found->target, DoorwayOf(graph_, map, link_point), options_);
    if (!(cost < found->cost)) return;
    if (std::isinf(found->cost)) ++reached_;
    found->cost = cost;
    if (reached_ < targets_.size()) return;
    bound_ = std::max_element(targets_.begin(), targets_.end(), [](const auto& a, const auto& b) {
               return a.cost < b.cost;
             })->cost;
  }

  bool IsBetter(const Entrance& a, const Entrance& b) const {
    if (a.cost != b.cost) return a.cost < b.cost;
    return a.hops != b.hops ? a.hops < b.hops : IsBefore(a.link_point, b.link_point);
  }

  // Orders two link points.
  bool IsBefore(int a, int b) const {
    return graph_.link_point_node(a).link_point->id < graph_.link_point_node(b).link_point->id;
  }

  // Orders two equally good paths.
  bool IsPreferred(const PathLabel& a, const PathLabel& b) const {
    if (a.previous != b.previous) {
      if (a.previous < 0 || b.previous < 0) return a.previous < 0;
      return IsBefore(a.previous, b.previous);
    }
    return a.map != b.map && graph_.map_node(a.map).map->id < graph_.map_node(b.map).map->id;
  }

  const GraphSnapshot& graph_;
  const std::vector<PathSource>& sources_;
  const PathOptions& options_;
  const double lever_squared_ = options_.lever_m * options_.lever_m;
  double bound_ = std::numeric_limits<double>::infinity();  // no target costs more, if all are reached
  std::vector<ReachedTarget> targets_;                      // by map
  std::size_t reached_ = 0;
  std::vector<PathLabel> labels_;
  std::vector<char> is_source_;      // by map slot
  std::vector<Entrance> entrances_;  // likewise
  std::priority_queue<Entry, std::vector<Entry>, Later> heap_;
};

template <typename Use>
auto WithCost(PathCost cost, const Use& use) {
  switch (cost) {
    case PathCost::kDistance:
      return use.template operator()<PathCost::kDistance>();
    case PathCost::kHops:
      return use.template operator()<PathCost::kHops>();
    case PathCost::kUncertainty:
      break;
  }
  return use.template operator()<PathCost::kUncertainty>();
}

Path Trace(const std::vector<PathLabel>& labels, int last, int target_map, double cost) {
  Path path{
      .cost = cost, .source = labels[static_cast<std::size_t>(last)].source, .maps = {target_map}, .link_points = {}};
  for (int at = last; at >= 0; at = labels[static_cast<std::size_t>(at)].previous) {
    path.link_points.push_back(at);
    path.maps.push_back(labels[static_cast<std::size_t>(at)].map);
  }
  std::reverse(path.maps.begin(), path.maps.end());
  std::reverse(path.link_points.begin(), path.link_points.end());
  return path;
}

// The path within one map, if source and target share it.
std::optional<Path> DirectPath(const std::vector<PathSource>& sources, const PathTarget& target,
                               const PathOptions& options) {
  std::optional<Path> best;
  for (int i = 0; i < static_cast<int>(sources.size()); ++i) {
    const PathSource& source = sources[static_cast<std::size_t>(i)];
    if (source.map != target.map) continue;
    double cost = source.cost;
    if (options.cost == PathCost::kDistance && source.position.has_value() && target.position.has_value()) {
      cost += (*target.position - *source.position).norm();
    }
    if (!best.has_value() || cost < best->cost) {
      best = Path{.cost = cost, .source = i, .maps = {target.map}, .link_points = {}};
    }
  }
  return best;
}

}  // namespace

std::vector<PathLabel> ShortestPaths(const GraphSnapshot& graph, const std::vector<PathSource>& sources,
                                     const PathOptions& options, const std::vector<PathTarget>& targets) {
  return WithCost(options.cost,
                  [&]<PathCost kCost>() { return Search<kCost>(graph, sources, options, targets).Run(); });
}

std::optional<Path> BestPath(const GraphSnapshot& graph, const std::vector<PathSource>& sources,
                             const std::vector<PathLabel>& labels, const PathTarget& target,
                             const PathOptions& options) {
  // A source in the target's map needs no link point, whatever other paths would cost.
  if (std::optional<Path> direct = DirectPath(sources, target, options)) return direct;
  if (options.without_maps != nullptr && options.without_maps->contains(target.map)) return std::nullopt;
  return WithCost(options.cost, [&]<PathCost kCost>() -> std::optional<Path> {
    double best = std::numeric_limits<double>::infinity();
    int best_hops = 0;
    int last = -1;
    for (const Doorway& doorway : graph.map_node(target.map).doorways) {
      const PathLabel& label = labels[static_cast<std::size_t>(doorway.link_point)];
      if (label.previous == -1 && label.source == -1) continue;
      if (label.map == target.map || !MayPass(graph.link_point_node(doorway.link_point), options)) continue;
      const double cost = label.cost + LastLegCost<kCost>(target, doorway, options);
      if (cost > best || (cost == best && label.hops >= best_hops)) continue;
      best = cost;
      best_hops = label.hops;
      last = doorway.link_point;
    }
    if (last < 0) return std::nullopt;
    return Trace(labels, last, target.map, best);
  });
}

double CostOf(const GraphSnapshot& graph, const PathSource& source, const Path& path, const PathTarget& target,
              const PathOptions& options) {
  if (path.link_points.empty()) return DirectPath({source}, target, options).value_or(Path{}).cost;
  return WithCost(options.cost, [&]<PathCost kCost>() {
    const double lever_squared = options.lever_m * options.lever_m;
    double cost = FirstLegCost<kCost>(source, DoorwayOf(graph, path.maps[0], path.link_points[0]), lever_squared);
    for (std::size_t i = 1; i < path.link_points.size(); ++i) {
      cost = CostAcross<kCost>(cost, DoorwayOf(graph, path.maps[i], path.link_points[i - 1]),
                               DoorwayOf(graph, path.maps[i], path.link_points[i]), lever_squared);
    }
    return cost + LastLegCost<kCost>(target, DoorwayOf(graph, path.maps.back(), path.link_points.back()), options);
  });
}

std::optional<Path> ShortestPath(const GraphSnapshot& graph, const std::vector<PathSource>& sources,
                                 const PathTarget& target, const PathOptions& options) {
  return BestPath(graph, sources, ShortestPaths(graph, sources, options, {target}), target, options);
}

}  // namespace enfilade::graph
