// SPDX-License-Identifier: Apache-2.0
#include "core/graph/paths/k_shortest_paths.h"

#include <algorithm>
#include <optional>
#include <set>
#include <unordered_set>
#include <utility>

namespace enfilade::graph {
namespace {

// By cost; ties go to the path with fewer, then smaller, link points.
struct Better {
  const GraphSnapshot* graph;

  bool operator()(const Path& a, const Path& b) const {
    if (a.cost != b.cost) return a.cost < b.cost;
    if (a.link_points.size() != b.link_points.size()) return a.link_points.size() < b.link_points.size();
    for (std::size_t i = 0; i < a.link_points.size(); ++i) {
      const LinkPointId& id_a = graph->link_point_node(a.link_points[i]).link_point->id;
      const LinkPointId& id_b = graph->link_point_node(b.link_points[i]).link_point->id;
      if (id_a != id_b) return id_a < id_b;
    }
    for (std::size_t i = 0; i < a.maps.size(); ++i) {
      const MapId& id_a = graph->map_node(a.maps[i]).map->id;
      const MapId& id_b = graph->map_node(b.maps[i]).map->id;
      if (id_a != id_b) return id_a < id_b;
    }
    return false;
  }
};

bool Repeats(std::vector<int> slots) {
  std::sort(slots.begin(), slots.end());
  return std::adjacent_find(slots.begin(), slots.end()) != slots.end();
}

// Whether the first `legs` legs of both are equal.
bool HasPrefix(const Path& path, const Path& prefix, std::size_t legs) {
  return path.link_points.size() >= legs &&
         std::equal(prefix.link_points.begin(), prefix.link_points.begin() + static_cast<std::ptrdiff_t>(legs),
                    path.link_points.begin()) &&
         std::equal(prefix.maps.begin(), prefix.maps.begin() + static_cast<std::ptrdiff_t>(legs), path.maps.begin());
}

class KShortest {
 public:
  KShortest(const GraphSnapshot& graph, const PathSource& source, const PathTarget& target, const PathOptions& options)
      : graph_(graph), source_(source), target_(target), options_(options), candidates_(Better{&graph}) {}

  std::vector<Path> Find(int count) {
    std::vector<Path> found;
    if (std::optional<Path> first = ShortestPath(graph_, {source_}, target_, options_)) {
      candidates_.insert(*std::move(first));
    }
    // If anchors contradict each other, a detour through other maps may seem shorter than the direct way within one.
    // Such paths are expanded but not returned.
    const std::size_t most = 10 * static_cast<std::size_t>(count) + 100;
    while (!candidates_.empty() && seen_.size() < most) {
      const Path path = *candidates_.begin();
      candidates_.erase(candidates_.begin());
      seen_.push_back(path);
      if (!Repeats(path.maps) && !Repeats(path.link_points)) found.push_back(path);
      if (found.size() == static_cast<std::size_t>(count)) break;
      for (std::size_t legs = 0; legs < path.maps.size(); ++legs) Deviate(path, legs);
    }
    return found;
  }

 private:
  // Adds the best paths that share the first `legs` legs with `path` and then deviate from it and from every path seen,
  // one for each map behind the link point reached.
  void Deviate(const Path& path, std::size_t legs) {
    const auto n = static_cast<std::ptrdiff_t>(legs);
    const std::unordered_set<int> link_points(path.link_points.begin(), path.link_points.begin() + n);
    const std::unordered_set<int> maps(path.maps.begin(), path.maps.begin() + n);
    std::unordered_set<std::int64_t> next_legs;
    bool ended = false;  // one of them ends with the next leg
    for (const Path& other : seen_) {
      if (!HasPrefix(other, path, legs)) continue;
      if (other.link_points.size() == legs) {
        ended = true;
      } else {
        next_legs.insert(LegKey(other.maps[legs], other.link_points[legs]));
      }
    }
    PathOptions options = options_;
    options.without_link_points = &link_points;
    options.without_maps = &maps;
    options.without_first_legs = &next_legs;
    for (const PathSource& spur_source : SpurSources(path, legs)) {
      if (maps.contains(spur_source.map) || (ended && spur_source.map == target_.map)) continue;
      const std::optional<Path> spur = ShortestPath(graph_, {spur_source}, target_, options);
      if (!spur.has_value()) continue;
      Path joined{.cost = 0.0,
                  .source = 0,
                  .maps = {path.maps.begin(), path.maps.begin() + n},
                  .link_points = {path.link_points.begin(), path.link_points.begin() + n}};
      joined.maps.insert(joined.maps.end(), spur->maps.begin(), spur->maps.end());
      joined.link_points.insert(joined.link_points.end(), spur->link_points.begin(), spur->link_points.end());
      joined.cost = CostOf(graph_, source_, joined, target_, options_);
      candidates_.insert(std::move(joined));
    }
  }

  // The maps behind the `legs`-th link point of the path.
  std::vector<PathSource> SpurSources(const Path& path, std::size_t legs) const {
    if (legs == 0) return {source_};
    const GraphSnapshot::LinkPointNode& node = graph_.link_point_node(path.link_points[legs - 1]);
    std::vector<PathSource> sources;
    for (std::size_t i = 0; i < node.maps.size(); ++i) {
      sources.push_back(
          {.map = node.maps[i], .cost = 0.0, .position = node.link_point->anchors[i].T_map_place.translation()});
    }
    return sources;
  }

  const GraphSnapshot& graph_;
  const PathSource& source_;
  const PathTarget& target_;
  const PathOptions& options_;
  std::set<Path, Better> candidates_;
  std::vector<Path> seen_;
};

}  // namespace

std::vector<Path> KShortestPaths(const GraphSnapshot& graph, const PathSource& source, const PathTarget& target,
                                 const PathOptions& options, int count) {
  return KShortest(graph, source, target, options).Find(count);
}

}  // namespace enfilade::graph
