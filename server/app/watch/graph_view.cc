// SPDX-License-Identifier: Apache-2.0
#include "server/app/watch/graph_view.h"

#include <algorithm>
#include <set>

#include "core/base/status_macros.h"

namespace enfilade::server {
namespace {

// More removals than this are forgotten with the versions that they belong to.
constexpr std::size_t kMaxRemoved = 10'000;

bool AreSamePlaces(const std::optional<PoseWithCovariance>& a, const std::optional<PoseWithCovariance>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return a->pose.x == b->pose.x && a->pose.y == b->pose.y && a->pose.yaw == b->pose.yaw &&
         a->covariance == b->covariance;
}

bool IsSame(const GraphView::Map& a, const GraphView::Map& b) {
  return (a.map == b.map || *a.map == *b.map) && a.optimized == b.optimized &&
         AreSamePlaces(a.T_world_map, b.T_world_map);
}

bool IsSame(const GraphView::LinkPoint& a, const GraphView::LinkPoint& b) {
  return (a.link_point == b.link_point || *a.link_point == *b.link_point) &&
         AreSamePlaces(a.T_world_place, b.T_world_place);
}

absl::StatusOr<std::vector<GraphView::Map>> PlaceMaps(const SiteGraph& graph) {
  std::vector<GraphView::Map> maps;
  maps.reserve(graph.lists().maps.size());
  for (const graph::MapInGraph* map : graph.lists().maps) {
    GraphView::Map& placed = maps.emplace_back();
    placed.map = map;
    placed.changed = graph.graph().version();
    ENFILADE_ASSIGN_OR_RETURN(const auto pose, graph.poses.Find(map->id));
    if (!pose) continue;
    placed.T_world_map = pose->T_world_robot;
    placed.optimized = pose->solution_version.has_value() && pose->hops.empty();
  }
  return maps;
}

const graph::MapInGraph& ItemOf(const GraphView::Map& map) { return *map.map; }
const graph::LinkPoint& ItemOf(const GraphView::LinkPoint& link_point) { return *link_point.link_point; }

// Walks through both lists, which are in the order of ids: calls kept(old, new) and gone(old).
template <typename Item, typename Kept, typename Gone>
void CompareById(const std::vector<Item>& before, std::vector<Item>& now, const Kept& kept, const Gone& gone) {
  auto item = now.begin();
  for (const Item& old : before) {
    while (item != now.end() && ItemOf(*item).id < ItemOf(old).id) ++item;
    if (item != now.end() && ItemOf(*item).id == ItemOf(old).id) {
      kept(old, *item);
    } else {
      gone(old);
    }
  }
}

void PlaceInWorld(const SiteGraph& graph, GraphView::LinkPoint& placed) {
  placed.T_world_place = graph::FindInWorld(graph.poses, *placed.link_point);
}

// Link points are many: only those that have changed or whose maps have moved are placed again.
void KeepLinkPoints(const GraphView& before, const std::set<MapId>& moved, GraphView& view) {
  std::vector<bool> is_placed(view.link_points.size(), false);
  const auto keep = [&](const GraphView::LinkPoint& old, GraphView::LinkPoint& now) {
    const auto has_moved = [&moved](const graph::Anchor& anchor) { return moved.contains(anchor.map); };
    const auto& anchors = now.link_point->anchors;
    if (old.link_point == now.link_point && std::none_of(anchors.begin(), anchors.end(), has_moved)) {
      now.T_world_place = old.T_world_place;
    } else {
      PlaceInWorld(*view.graph, now);
    }
    is_placed[static_cast<std::size_t>(&now - view.link_points.data())] = true;
    if (IsSame(old, now)) now.changed = old.changed;
  };
  CompareById(before.link_points, view.link_points, keep, [&](const GraphView::LinkPoint& old) {
    view.removed_link_points.push_back({old.link_point->id, view.version()});
  });
  for (std::size_t i = 0; i < is_placed.size(); ++i) {
    if (!is_placed[i]) PlaceInWorld(*view.graph, view.link_points[i]);
  }
}

void KeepWhatIsUnchanged(const GraphView& before, GraphView& view) {
  view.since = before.since;
  view.removed_maps = before.removed_maps;
  view.removed_link_points = before.removed_link_points;
  std::set<MapId> moved;
  for (const GraphView::Map& map : view.maps) moved.insert(map.map->id);
  const auto keep = [&moved](const GraphView::Map& old, GraphView::Map& now) {
    if (AreSamePlaces(old.T_world_map, now.T_world_map)) moved.erase(now.map->id);
    if (IsSame(old, now)) now.changed = old.changed;
  };
  CompareById(before.maps, view.maps, keep, [&view](const GraphView::Map& old) {
    view.removed_maps.push_back({old.map->id, view.version()});
  });
  KeepLinkPoints(before, moved, view);
}

template <typename Id>
void ForgetOldRemovals(std::vector<GraphView::Removed<Id>>& removed, std::int64_t& since) {
  if (removed.size() <= kMaxRemoved) return;
  // Whole versions only: in the order of versions, as they were added.
  since = std::max(since, removed[removed.size() - kMaxRemoved].version);
  std::erase_if(removed, [&](const GraphView::Removed<Id>& gone) { return gone.version <= since; });
}

}  // namespace

absl::StatusOr<std::shared_ptr<const GraphView>> Following(const std::shared_ptr<const GraphView>& before,
                                                           const std::shared_ptr<const SiteGraph>& graph) {
  if (before != nullptr && before->graph == graph) return before;
  auto view = std::make_shared<GraphView>();
  view->graph = graph;
  ENFILADE_ASSIGN_OR_RETURN(view->maps, PlaceMaps(*graph));
  for (const graph::LinkPoint* link_point : graph->lists().link_points) {
    view->link_points.push_back({link_point, std::nullopt, graph->graph().version()});
  }
  for (const GraphView::Map& map : view->maps) view->disconnected_maps += map.T_world_map.has_value() ? 0 : 1;
  if (before != nullptr && before->version() <= view->version()) {
    KeepWhatIsUnchanged(*before, *view);
    ForgetOldRemovals(view->removed_maps, view->since);
    ForgetOldRemovals(view->removed_link_points, view->since);
  } else {
    view->since = view->version();
    for (GraphView::LinkPoint& link_point : view->link_points) PlaceInWorld(*graph, link_point);
  }
  return std::shared_ptr<const GraphView>(std::move(view));
}

}  // namespace enfilade::server
