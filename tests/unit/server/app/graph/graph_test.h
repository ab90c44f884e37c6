// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "server/app/graph/site_graphs.h"
#include "tests/fakes/in_memory_stores.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/server/app/graph/graph_store_probe.h"
#include "tests/unit/server/app/test_values.h"

namespace enfilade::server {

// Site "campus" with the maps a (the root), b and c, doors "ab" and "bc" 10 m along x from the origin of the one to
// that of the next; and site "other" without maps.
class AppGraphTest : public ::testing::Test {
 protected:
  AppGraphTest() {
    stores_.database.AddSite(site_);
    stores_.database.AddSite(other_site_);
    for (const char* map : {"a", "b", "c"}) AddMap(map);
    Join("ab", "a", "b", {10, 0, 0});
    Join("bc", "b", "c", {10, 0, 0});
  }

  void AddMap(const std::string& id) { EXPECT_OK(stores_.maps.Create(Soon(), MakeMap(site_, id), "")); }
  void Join(const std::string& id, const std::string& from, const std::string& to, const Pose2& T_from_place) {
    EXPECT_OK(stores_.link_points.Create(Soon(), MakeDoor(site_, id, from, to, T_from_place), ""));
  }
  // Places door "bc" at (x, 0) in b, past SiteGraphs, as another process does. Returns the graph's version.
  std::int64_t MoveDoor(double x) {
    auto door = stores_.link_points.Get(Soon(), site_, LinkPointId("bc"));
    EXPECT_OK(door);
    door->point.anchors[0].T_map_place.x = x;
    EXPECT_OK(stores_.link_points.Update(Soon(), *door));
    return Version();
  }
  std::int64_t Version() const { return *stores_.graphs.GetVersion(Soon(), site_); }

  std::shared_ptr<const SiteGraph> Get() { return Get(site_); }
  std::shared_ptr<const SiteGraph> Get(const SiteId& site) {
    auto graph = graphs_->Get(Soon(), site);
    EXPECT_OK(graph);
    return graph.ok() ? *graph : nullptr;
  }
  void Start() { graphs_.emplace(probe_, changed_); }
  // Until SiteGraphs listens, and so answers from memory.
  void StartListening() {
    Start();
    Get();
    while (graphs_->FindCurrent(site_) == nullptr) {
      Get();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  // Until a notification has brought the graph to `version`.
  std::shared_ptr<const SiteGraph> AwaitVersion(std::int64_t version) {
    while (true) {
      const auto graph = graphs_->FindCurrent(site_);
      if (graph != nullptr && graph->graph().version() >= version) return graph;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

  const SiteId site_{"campus"};
  const SiteId other_site_{"other"};
  testing::InMemoryStores stores_;
  GraphStoreProbe probe_{stores_.graphs};
  ChangedSites changed_;
  std::optional<SiteGraphs> graphs_;
};

// x of map c's origin in the world, m.
inline double WorldXOfC(const SiteGraph& graph) {
  const auto pose = graph.poses.Find(MapId("c"));
  EXPECT_OK(pose);
  EXPECT_TRUE(pose->has_value());
  return (*pose)->T_world_robot.pose.x;
}

}  // namespace enfilade::server
