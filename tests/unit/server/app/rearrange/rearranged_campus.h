// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/slam/slam_profiles.h"
#include "fmt/format.h"
#include "server/app/graph/site_graphs.h"
#include "server/app/rearrange/map_rearrangements.h"
#include "server/app/rearrange/rearranger.h"
#include "tests/fakes/in_memory_stores.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/server/app/test_values.h"

namespace enfilade::server {

// What the server merges and splits maps with, over the stores in memory: site "campus" with robot "r".
class RearrangedCampus : public ::testing::Test {
 protected:
  RearrangedCampus() {
    stores_.database.AddSite(site_);
    stores_.database.AddRobot(site_, RobotId("r"));
  }

  void AddMap(const std::string& id, int level = 0) {
    storage::Map map = MakeMap(site_, id);
    map.level = level;
    ASSERT_OK(stores_.maps.Create(Soon(), map, ""));
    graphs_.MarkChanged(site_);
  }
  void Join(const std::string& id, const std::string& a, const Pose2& T_a_place, const std::string& b,
            const Pose2& T_b_place, double variance_scale = 1.0) {
    storage::StoredLinkPoint point = MakeDoor(site_, id, a, b, T_a_place);
    point.point.anchors[1].T_map_place = T_b_place;
    for (graph::Anchor& anchor : point.point.anchors) anchor.covariance *= variance_scale;
    ASSERT_OK(stores_.link_points.Create(Soon(), point, ""));
    graphs_.MarkChanged(site_);
  }
  // Recorded and not yet mapped.
  void Record(const std::string& id, const std::string& map) {
    ASSERT_OK(stores_.sessions.Create(Soon(), MakeSession(site_, id, map), ""));
    ASSERT_OK(stores_.records.Append(Soon(), {site_, SessionId(id), OdometryRecords(1, 4), {}}));
    ASSERT_OK(stores_.sessions.Finish(Soon(), site_, SessionId(id), 4));
  }
  // With four keyframes, the first one at T_map_robot, each 0.1 m on.
  void AddMapped(const std::string& id, const std::string& map, const Pose2& T_map_robot) {
    Record(id, map);
    const auto leased = stores_.mappings.Acquire(Soon(), "worker", std::chrono::seconds(60));
    ASSERT_OK(leased);
    ASSERT_TRUE(leased->has_value());
    ASSERT_EQ((*leased)->session.id.value(), id);
    slam::SlamDelta delta;
    delta.submaps = {{0, 1, T_map_robot, true, "content"}};
    for (std::int64_t i = 0; i < 4; ++i) {
      const Pose2 T_map_node = T_map_robot * Pose2{0.1 * static_cast<double>(i), 0, 0};
      delta.nodes.push_back({i, i + 1, (i + 1) * kNsPerSecond, T_map_node, Eigen::Matrix3d::Identity() * 1e-4, 0});
      delta.trajectory.push_back({i + 1, (i + 1) * kNsPerSecond, i, {}});
    }
    storage::MappingStep step{delta, "checkpoint", {}, 4, nullptr, {}, storage::SessionState::kMapped, ""};
    ASSERT_OK(stores_.mappings.Commit(Soon(), (*leased)->lease, step));
  }

  absl::StatusOr<storage::StoredRearrangement> Merge(const std::string& kept, const std::string& merged,
                                                     const std::optional<Pose2>& T_kept_merged = std::nullopt) {
    return rearrangements_.Apply(Soon(), site_, MapRearrangements::Merge{MapId(kept), MapId(merged), T_kept_merged});
  }
  absl::StatusOr<storage::StoredRearrangement> Split(const std::string& map, const std::vector<SessionId>& leaving,
                                                     const std::string& new_map,
                                                     const std::vector<rearrange::SessionCut>& cuts = {}) {
    return rearrangements_.Apply(Soon(), site_, MapRearrangements::Split{MapId(map), leaving, cuts, MapId(new_map)});
  }
  absl::StatusOr<storage::StoredRearrangement> Undo(const rearrange::RearrangementId& id) {
    return rearrangements_.Undo(Soon(), site_, id);
  }

  std::int64_t Version() const { return *stores_.graphs.GetVersion(Soon(), site_); }
  MapId MapOf(const SessionId& session) const { return *stores_.sessions.Get(Soon(), site_, session)->map; }
  Pose2 WorldPoseOf(const SessionId& session) const {
    const MapId map = MapOf(session);
    const auto places = stores_.graphs.GetPlaces(Soon(), site_, {map});
    const auto nodes = stores_.mappings.ListKeyframes(Soon(), site_, session);
    if (!places.ok() || places->empty() || !nodes.ok() || nodes->empty()) {
      ADD_FAILURE() << session.value() << " has no place in the world";
      return {};
    }
    return places->front().T_world_map.pose * nodes->front().T_map_node;
  }

  const SiteId site_{"campus"};
  testing::InMemoryStores stores_;
  ChangedSites changed_;
  SiteGraphs graphs_{stores_.graphs, changed_};
  const slam::SlamProfiles profiles_;
  const Rearranger::Stores used_{stores_.sessions,  stores_.mappings, stores_.maps,
                                 stores_.revisions, stores_.blobs,    stores_.rearrangements};
  const Rearranger rearranger_{used_, profiles_, graphs_};
  const MapRearrangements rearrangements_{used_, stores_.site_leases, rearranger_, graphs_, "Map"};
};

}  // namespace enfilade::server
