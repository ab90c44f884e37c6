// SPDX-License-Identifier: Apache-2.0
#include "core/graph/paths/shortest_paths.h"

#include <algorithm>
#include <cmath>
#include <queue>

namespace enfilade::graph {
namespace {

using Doorway = GraphSnapshot::Doorway;

// What lies ahead on the heap.
struct Entry {
  double cost = 0.0;
  int hops = 0;
  int link_point = 0;
};
struct Later {
  bool operator()(const Entry& a, const Entry& b) const { return a.cost != b.cost ? a.cost > b.cost : a.hops > b.hops; }
};

// The best that a map was entered with so far. Where legs cost the sum of what their ends cost, nobody who enters with
// more gets anywhere for less.
struct Entrance {
  double cost = std::numeric_limits<double>::infinity();
  int hops = 0;
  int link_point = -1;
};

// From anywhere in a map, or from `position`, to the link point at the doorway; or back.
template <PathCost kCost>
double EndCost(const std::optional<Eigen::Vector2d>& position, const Doorway& doorway, double lever_squared) {
  if constexpr (kCost == PathCost::kUncertainty) {
    return doorway.position_spread + doorway.yaw_variance * lever_squared;
  } else if constexpr (kCost == PathCost::kDistance) {
    return position.has_value() ? std::hypot(position->x() - doorway.x, position->y() - doorway.y) : 0.0;
  } else {
    return 0.0;
  }
}

// The same of the anchor at that doorway, where legs are sums.
template <PathCost kCost>
double EndCost(const Eigen::Matrix3d& covariance, double lever_squared) {
  if constexpr (kCost == PathCost::kUncertainty) {
    return UncertaintyOf(covariance, lever_squared);
  } else {
    return 0.0;
  }
}

// Legs within a map cost the sum of what their two ends cost.
template <PathCost kCost>
constexpr bool kLegsAreSums = kCost != PathCost::kDistance;

// A way that has cost so much, having entered a map by one doorway and crossed it to another.
template <PathCost kCost>
double CostAcross(double cost, const Doorway& from, const Doorway& to, double lever_squared) {
  if constexpr (kLegsAreSums<kCost>) {
    // In this order: who enters with less is at no doorway behind who enters with more, rounding included.
    return cost + EndCost<kCost>({}, from, lever_squared) + EndCost<kCost>({}, to, lever_squared) +
           (kCost == PathCost::kHops ? 1.0 : 0.0);
  } else {
    const double dx = to.x - from.x;
    const double dy = to.y - from.y;
    return cost + std::sqrt(dx * dx + dy * dy);
  }
}

// The first leg.
template <PathCost kCost>
double FirstLegCost(const PathSource& source, const Doorway& doorway, double lever_squared) {
  return source.cost + EndCost<kCost>(source.position, doorway, lever_squared) + (kCost == PathCost::kHops ? 1.0 : 0.0);
}

const Doorway& DoorwayOf(const GraphSnapshot& graph, int map, int link_point) {
  const std::vector<Doorway>& doorways = graph.map_node(map).doorways;
  return *std::find_if(doorways.begin(), doorways.end(),
                       [link_point](const Doorway& doorway) { return doorway.link_point == link_point; });
}

// The last leg. The yaw's lever is known there.
template <PathCost kCost>
double LastLegCost(const PathTarget& target, const Doorway& doorway, const PathOptions& options) {
  const double lever_squared = target.position.has_value()
                                   ? (*target.position - Eigen::Vector2d(doorway.x, doorway.y)).squaredNorm()
                                   : options.lever_m * options.lever_m;
  return EndCost<kCost>(target.position, doorway, lever_squared);
}

bool MayPass(const GraphSnapshot::LinkPointNode& node, const PathOptions& options) {
  if (!options.passable_at.has_value() || node.state == PassageState::kOpen) return true;
  return node.state_valid_until.has_value() && *options.passable_at >= *node.state_valid_until;
}

template <PathCost kCost>
class Search {
 public:
  Search(const GraphSnapshot& graph, const std::vector<PathSource>& sources, const PathOptions& options,
         const std::optional<PathTarget>& target)
      : graph_(graph),
        sources_(sources),
        options_(options),
        target_(target),
        labels_(graph.link_point_slots()),
        is_source_(graph.map_slots()),
        entrances_(kLegsAreSums<kCost> ? graph.map_slots() : 0) {
    for (const PathSource& source : sources_) is_source_[static_cast<std::size_t>(source.map)] = 1;
  }

  std::vector<PathLabel> Run() {
    for (int i = 0; i < static_cast<int>(sources_.size()); ++i) Begin(i);
    while (!heap_.empty()) {
      const Entry entry = heap_.top();
      heap_.pop();
      const PathLabel& label = labels_[static_cast<std::size_t>(entry.link_point)];
      if (entry.cost != label.cost || entry.hops != label.hops) continue;  // a better way was found since
      if (entry.cost > bound_) break;
      Settle(entry, label.map, label.source);
    }
    return std::move(labels_);
  }

 private:
  void Begin(int source_index) {
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
      if (label.hops == current.hops && !GoesBefore(label, current)) return;
    }
    if (options_.without_link_points != nullptr && options_.without_link_points->contains(link_point)) return;
    const bool is_better = label.cost < current.cost || label.hops < current.hops;
    current = label;
    if (LeadsOn(link_point, label, is_better)) {
      heap_.push({.cost = label.cost, .hops = label.hops, .link_point = link_point});
    }
  }

  // Is there a map behind the link point that may be worth entering by it? Where legs are sums, only one that nothing
  // else is known to enter for less: so each map is crossed about once instead of from each of its doorways.
  bool LeadsOn(int link_point, const PathLabel& label, bool is_better) {
    const GraphSnapshot::LinkPointNode& node = graph_.link_point_node(link_point);
    if (!MayPass(node, options_)) return false;
    bool leads_on = false;
    for (std::size_t i = 0; i < node.maps.size(); ++i) {
      const int map = node.maps[i];
      if (!MayEnter(map, label.map)) continue;
      if (target_.has_value() && map == target_->map) {
        const double cost = label.cost + LastLegCost<kCost>(*target_, DoorwayOf(graph_, map, link_point), options_);
        bound_ = std::min(bound_, cost);
      }
      if constexpr (kLegsAreSums<kCost>) {
        const double end = EndCost<kCost>(node.link_point->anchors[i].covariance, lever_squared_);
        const Entrance entrance{.cost = label.cost + end, .hops = label.hops, .link_point = link_point};
        Entrance& best = entrances_[static_cast<std::size_t>(map)];
        if (!IsBetter(entrance, best)) continue;
        best = entrance;
        leads_on = true;
      } else {
        leads_on = is_better;
      }
    }
    return leads_on;
  }

  bool IsBetter(const Entrance& a, const Entrance& b) const {
    if (a.cost != b.cost) return a.cost < b.cost;
    return a.hops != b.hops ? a.hops < b.hops : IsBefore(a.link_point, b.link_point);
  }

  // Of two link points.
  bool IsBefore(int a, int b) const {
    return graph_.link_point_node(a).link_point->id < graph_.link_point_node(b).link_point->id;
  }

  // Of two ways that are equally good.
  bool GoesBefore(const PathLabel& a, const PathLabel& b) const {
    if (a.previous != b.previous) {
      if (a.previous < 0 || b.previous < 0) return a.previous < 0;
      return IsBefore(a.previous, b.previous);
    }
    return a.map != b.map && graph_.map_node(a.map).map->id < graph_.map_node(b.map).map->id;
  }

  const GraphSnapshot& graph_;
  const std::vector<PathSource>& sources_;
  const PathOptions& options_;
  const std::optional<PathTarget>& target_;
  const double lever_squared_ = options_.lever_m * options_.lever_m;
  double bound_ = std::numeric_limits<double>::infinity();  // of the best way to the target so far
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

// Within one map.
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
                                     const PathOptions& options, const std::optional<PathTarget>& target) {
  return WithCost(options.cost, [&]<PathCost kCost>() { return Search<kCost>(graph, sources, options, target).Run(); });
}

std::optional<Path> BestPath(const GraphSnapshot& graph, const std::vector<PathSource>& sources,
                             const std::vector<PathLabel>& labels, const PathTarget& target,
                             const PathOptions& options) {
  // What lies in the target's map from the start needs no way there, whatever it would cost.
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
  return BestPath(graph, sources, ShortestPaths(graph, sources, options, target), target, options);
}

}  // namespace enfilade::graph
