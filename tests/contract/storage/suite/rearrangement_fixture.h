// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/base/sha256.h"
#include "fmt/format.h"
#include "storage/graph/rearrangement_store.h"
#include "tests/contract/storage/store_values.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"

namespace enfilade::testing {

// The hall (the root) with session s1, the lab with s2, which came from s1 through the door, and a yard behind the lab;
// what rearrangements are made of them. `Base` has the stores: StoreContractTest, or a test of one implementation.
template <typename Base>
class RearrangementFixture : public Base {
 protected:
  using Base::Append, Base::NewSession, Base::Soon;
  using Base::blobs_, Base::graph_, Base::leases_, Base::link_points_, Base::mapping_, Base::maps_, Base::records_,
      Base::revisions_, Base::robot_poses_, Base::sessions_;
  using Base::map_, Base::robot_, Base::site_;

  RearrangementFixture() {
    EXPECT_OK(maps_.Create(Soon(), MakeMap(site_, lab_, "Lab"), ""));
    EXPECT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("yard"), "Yard"), ""));
    MapSession(NewSession("s1"), 1);
    storage::Session second = MakeSession(site_, s2_, robot_, lab_);
    second.entry.previous = s1_;
    second.entry.T_map_robot = PoseWithCovariance{{0.5, 0.25, 0.3}, Eigen::Vector3d(0.01, 0.04, 0.02).asDiagonal()};
    EXPECT_OK(sessions_.Create(Soon(), second, ""));
    MapSession(s2_, 2);
    EXPECT_OK(link_points_.Create(
        Soon(), MakeLinkPoint(site_, "door", {MakeAnchor("hall", 4, 5), MakeAnchor("lab", 0, 0)}), ""));
    EXPECT_OK(link_points_.Create(
        Soon(), MakeLinkPoint(site_, "gate", {MakeAnchor("lab", 3, 1, 0.4), MakeAnchor("yard", 0, 0)}), ""));
    EXPECT_OK(link_points_.Create(Soon(), MakeLinkPoint(site_, "seen", {MakeAnchor("lab", -2, 1)}), ""));
    EXPECT_OK(blobs_.Put(Soon(), site_, std::vector<storage::BlobView>{image_.view()}));
    storage::Evidence evidence{LinkPointId("gate"), lab_, storage::EvidenceKind::kFrontImage, 1, image_.ref(), 5, {}};
    evidence.T_map_robot = Pose2{2, 1, 0.4};
    EXPECT_OK(link_points_.PutEvidence(Soon(), site_, evidence));
    EXPECT_OK(graph_.SetControlPoints(Soon(), site_, {{map_, {0, 0}, 48, 11}, {lab_, {1, 2}, 48, 11}}));
    EXPECT_OK(
        robot_poses_.Report(Soon(), {site_, robot_, lab_, s2_, {{1, 1, 0.1}, Eigen::Matrix3d::Identity()}, 99, 0}));
    const auto lease = leases_.Acquire(Soon(), site_, "me", std::chrono::seconds(300));
    EXPECT_OK(lease);
    lease_ = lease->value_or(storage::SiteLease());
  }

  // Two keyframes in two submaps, with a closure and a track, and a raster of one tile.
  void MapSession(const SessionId& session, double seed) {
    Eigen::Matrix3d covariance;
    covariance << 0.02, 0.001, 0.002, 0.001, 0.03, -0.001, 0.002, -0.001, 0.01;
    slam::SlamDelta delta;
    delta.submaps = {{0, 1, {0.1 * seed, 0.2, 0.05}, true, "grid"}, {1, 1, {2.1, 0.3 * seed, -3.1}, true, "grid"}};
    delta.nodes = {{0, 1, 10, {1.0 / 3.0, seed, 0.1}, covariance, 0},
                   {1, 3, 30, {2.0 / 7.0, -seed, 3.1}, covariance, 1}};
    delta.loop_closures.push_back(
        {0, 0, 1, {1, 0, 0}, Eigen::Matrix3d::Identity(), slam::LoopClosureState::kAccepted, 0.5, 1.0, ""});
    delta.trajectory = {{1, 10, 0, {}}, {2, 20, 0, {0.5, 0.1, 0.2}}, {3, 30, 1, {}}};
    MapScans(session, 3, delta);
  }
  // A session of `scans` records, from which mapping has made `delta`.
  void MapScans(const SessionId& session, int scans, const slam::SlamDelta& delta) {
    for (int i = 1; i <= scans; ++i) ASSERT_OK(Append(session, {ScanRecord(i)}));
    ASSERT_OK(sessions_.Finish(Soon(), site_, session, scans));
    const auto leased = mapping_.Acquire(Soon(), "w", std::chrono::seconds(300));
    ASSERT_OK(leased);
    ASSERT_TRUE(leased->has_value());
    ASSERT_EQ((*leased)->lease.session, session);
    storage::NewRevision revision = RevisionOf({session.value()});
    revision.session = session;
    revision.source = storage::RevisionSource::kMapping;
    storage::MappingStep step = StepOf(delta, "checkpoint", scans);
    step.revision = &revision;
    step.final_state = storage::SessionState::kMapped;
    ASSERT_OK(mapping_.Commit(Soon(), (*leased)->lease, step));
    ASSERT_OK(mapping_.Release(Soon(), (*leased)->lease, 0));
  }
  storage::StoredRaster RasterOf(const std::vector<std::string>& contents) {
    storage::StoredRaster raster{"header", {}};
    for (const std::string& content : contents) {
      const TestBlob blob(content);
      EXPECT_OK(blobs_.Put(Soon(), site_, std::vector<storage::BlobView>{blob.view()}));
      raster.tiles.push_back({{0, static_cast<int>(raster.tiles.size())}, blob.sha256()});
    }
    return raster;
  }
  storage::NewRevision RevisionOf(const std::vector<std::string>& contents) {
    const storage::StoredRaster raster = RasterOf(contents);
    storage::NewRevision revision;
    revision.geometry = {0.05, {}, 256, 256};
    revision.raster_header = raster.header;
    revision.tiles = raster.tiles;
    for (const std::string& content : contents) revision.content_sha256 += content;
    revision.content_sha256 = Sha256(revision.content_sha256);
    return revision;
  }

  storage::RearrangedRaster Raster(const std::string& map, const std::string& session,
                                   const std::vector<std::string>& contents) {
    storage::RearrangedRaster raster;
    raster.map = MapId(map);
    raster.layers_version = revisions_.ReadLayersBeside(Soon(), site_, raster.map, SessionId("none"))->version;
    raster.entering = {{SessionId(session), RasterOf({session + " moved"})}};
    raster.revision = RevisionOf(contents);
    raster.revision->source = storage::RevisionSource::kMapping;
    raster.revision->session = SessionId(session);
    return raster;
  }
  // The lab becomes a part of the hall: the door goes, the gate and the candidate move.
  storage::RearrangementChange Merge(const std::string& id = "merge") {
    storage::RearrangementChange change;
    change.id = rearrange::RearrangementId(id);
    rearrange::Rearrangement& merge = change.rearrangement;
    merge.moves = {{s2_, map_, kHallLab}};
    merge.redirects = {{lab_, map_, kHallLab}};
    merge.removed_link_points = {LinkPointId("door")};
    merge.link_points = {Moved("gate", "lab", "hall"), Moved("seen", "lab", "hall")};
    merge.reason = "one room";
    change.graph_version = Version();
    change.rasters = {Raster("hall", "s2", {"s1", "s2 moved"})};
    return change;
  }
  // s2 leaves the hall for a map of its own, once it is there.
  storage::RearrangementChange Split() {
    storage::RearrangementChange change;
    change.id = rearrange::RearrangementId("split");
    rearrange::Rearrangement& split = change.rearrangement;
    split.new_maps = {{MapId("annex"), "Map", 0, Environment::kIndoor, "wide"}};
    split.moves = {{s2_, MapId("annex"), {1, 2, 0.5}}};
    split.link_points = {MakeLinkPoint(site_, "arch", {MakeAnchor("hall", 1, 1), MakeAnchor("annex", 2, 2)}).point};
    change.graph_version = Version();
    change.rasters = {Raster("annex", "s2", {"s2 split"}), Raster("hall", "s1", {"s1 alone"})};
    change.rasters[1].entering.clear();
    return change;
  }
  // s2 lies elsewhere in the lab than was thought.
  storage::RearrangementChange Shift() {
    storage::RearrangementChange change;
    change.id = rearrange::RearrangementId("shift");
    change.rearrangement.moves = {{s2_, lab_, {0.25, -0.125, 0.05}}};
    change.graph_version = Version();
    change.rasters = {Raster("lab", "s2", {"s2 moved"})};
    return change;
  }
  // s2 is cut behind its first keyframe, and its rest gets a map of its own.
  storage::RearrangementChange Cut(std::int64_t first_sequence = 2) {
    storage::RearrangementChange change;
    change.id = rearrange::RearrangementId("cut");
    rearrange::Rearrangement& cut = change.rearrangement;
    cut.new_maps = {{MapId("annex"), "Map", 0, Environment::kIndoor, ""}};
    cut.cuts = {{s2_, first_sequence, SessionId("s2b")}};
    cut.moves = {{SessionId("s2b"), MapId("annex"), {1, 2, 0.5}}};
    change.graph_version = Version();
    change.rasters = {Raster("annex", "s2b", {"s2b"}), Raster("lab", "s2", {"s2 head"})};
    return change;
  }
  graph::LinkPoint Moved(const std::string& id, const std::string& from, const std::string& to) {
    graph::LinkPoint point = link_points_.Get(Soon(), site_, LinkPointId(id))->point;
    for (graph::Anchor& anchor : point.anchors) {
      if (anchor.map != MapId(from)) continue;
      const PoseWithCovariance moved = rearrange::Moved(kHallLab, {anchor.T_map_place, anchor.covariance});
      anchor = {MapId(to), moved.pose, moved.covariance};
    }
    return point;
  }
  std::int64_t Version() { return graph_.GetVersion(Soon(), site_).value_or(-1); }

  // Everything that a rearrangement may change, as text.
  std::string Everything() {
    std::string all;
    for (const storage::Session& session : ValueOf(sessions_.List(Soon(), site_, {}, 100, std::nullopt))) {
      const storage::RecordCounts& counts = session.record_counts;
      all += fmt::format("session {} map {} state {} to {} of {}, {} scans, {} bytes, mapped {} used {} after {}\n",
                         session.id.value(), session.map.value_or(MapId()).value(), static_cast<int>(session.state),
                         session.acknowledged_sequence, session.highest_sequence, counts.laser_scans,
                         session.payload_bytes, session.mapped_sequence, session.mapping_counts.used,
                         session.entry.previous.value_or(SessionId()).value());
      if (session.entry.T_map_robot) all += "  entry " + Text(*session.entry.T_map_robot);
      all += SlamOf(session.id);
      for (const sensor::Record& record : ValueOf(records_.Read(Soon(), site_, session.id, 1, 1 << 20))) {
        all += fmt::format("  record {}\n", record.sequence);
      }
    }
    for (const storage::Map& map : ValueOf(maps_.List(Soon(), site_, storage::PageRequest{}))) {
      all += fmt::format("map {} {}\n", map.id.value(), map.display_name) + RasterOfMap(map.id);
    }
    for (const storage::MapPose& place : ValueOf(graph_.GetPlaces(Soon(), site_, {}))) {
      all += fmt::format("place of {} ", place.map.value()) + Text(place.T_world_map);
    }
    for (const auto& point : ValueOf(link_points_.List(Soon(), site_, {}, storage::PageRequest{}))) {
      all += LinkPointText(point);
    }
    for (const storage::ControlPoint& point : ValueOf(graph_.GetControlPoints(Soon(), site_))) {
      all += fmt::format("control point {} {} {}\n", point.map.value(), point.position.x(), point.position.y());
    }
    for (const storage::RobotPose& pose : ValueOf(robot_poses_.List(Soon(), site_))) {
      all += fmt::format("robot {} in {} {} ", pose.robot.value(), pose.map.value(),
                         pose.session.value_or(SessionId()).value()) +
             Text(pose.T_map_robot);
    }
    return all;
  }

  const Pose2 kHallLab{4, 5, M_PI / 2};  // T_hall_lab
  const MapId lab_{"lab"};
  const SessionId s1_{"s1"}, s2_{"s2"};
  const TestBlob image_{"image"};
  storage::SiteLease lease_;

 private:
  template <typename T>
  static T ValueOf(absl::StatusOr<T> value) {
    EXPECT_OK(value);
    return value.ok() ? *std::move(value) : T();
  }
  static std::string Text(const PoseWithCovariance& pose) {
    std::string text = fmt::format("({} {} {})", pose.pose.x, pose.pose.y, pose.pose.yaw);
    for (int i = 0; i < 9; ++i) text += fmt::format(" {}", pose.covariance(i / 3, i % 3));
    return text + "\n";
  }
  std::string SlamOf(const SessionId& session) {
    std::string text;
    const auto stored = ValueOf(mapping_.Load(Soon(), site_, session));
    if (!stored) return text;
    const Eigen::Matrix3d none = Eigen::Matrix3d::Zero();
    for (const auto& [id, submap] : stored->map.submaps) {
      text += fmt::format("  submap {} {} ", id, submap.content) + Text({submap.T_map_submap, none});
    }
    for (const auto& [id, node] : stored->map.nodes) {
      text += fmt::format("  node {} in {} ", id, node.submap) + Text({node.T_map_node, node.covariance});
    }
    for (const auto& [id, closure] : stored->map.loop_closures) {
      text += fmt::format("  closure {} ", id) + Text({closure.T_submap_node, none});
    }
    for (const slam::TrajectoryPoint& point : stored->map.trajectory) {
      text += fmt::format("  at {} {} ", point.sequence, point.node) + Text({point.T_node_robot, none});
    }
    return text;
  }
  std::string RasterOfMap(const MapId& map) {
    std::string text;
    if (const auto revision = revisions_.Get(Soon(), site_, map, 0); revision.ok()) {
      text += "  raster " + ToHex(revision->content_sha256) + "\n";
    }
    const storage::LayersBeside layers = ValueOf(revisions_.ReadLayersBeside(Soon(), site_, map, SessionId("none")));
    for (const storage::MapLayer& layer : layers.below) {
      text += fmt::format("  layer of {} {}", layer.session.value_or(SessionId()).value(), layer.raster.header);
      for (const storage::TileRef& tile : layer.raster.tiles) text += " " + ToHex(tile.sha256);
      text += "\n";
    }
    return text;
  }
  std::string LinkPointText(const storage::StoredLinkPoint& stored) {
    const graph::LinkPoint& point = stored.point;
    std::string text = fmt::format("link point {} {} '{}' into '{}'\n", point.id.value(), static_cast<int>(point.kind),
                                   point.tag, point.direction.value());
    if (stored.T_world_place) text += "  place " + Text(*stored.T_world_place);
    for (const graph::Anchor& anchor : point.anchors) {
      text += fmt::format("  anchor {} ", anchor.map.value()) + Text({anchor.T_map_place, anchor.covariance});
    }
    for (const storage::Evidence& evidence : ValueOf(link_points_.ListEvidence(Soon(), site_, {point.id}))) {
      text += fmt::format("  evidence {} {} ", evidence.map.value(), static_cast<int>(evidence.kind)) +
              Text({evidence.T_map_robot.value_or(Pose2()), Eigen::Matrix3d::Zero()});
    }
    return text;
  }
};

}  // namespace enfilade::testing
