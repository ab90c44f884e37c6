// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cmath>

#include "core/base/sha256.h"
#include "storage/graph/door_verdict_store.h"
#include "storage/postgres/graph/site_lease_store.h"
#include "storage/postgres/rearrange/rearrangement_store.h"
#include "storage/sites/maintenance.h"
#include "tests/contract/storage/store_test.h"
#include "tests/support/pose_matchers.h"

namespace enfilade::testing {

// The hall (the root) with session s1, the lab with s2, which came from s1 through the door, and a yard behind the lab.
class RearrangementStoreTest : public StoreTest {
 protected:
  RearrangementStoreTest() {
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
    Judge();
    const auto lease = leases_.Acquire(Soon(), site_, "me", std::chrono::seconds(300));
    EXPECT_OK(lease);
    lease_ = lease->value_or(storage::SiteLease());
  }

  // Two keyframes in two submaps, with a closure and a track, and a raster of one tile.
  void MapSession(const SessionId& session, double seed) {
    ASSERT_OK(Append(session, {ScanRecord(1), ScanRecord(2), ScanRecord(3)}));
    ASSERT_OK(sessions_.Finish(Soon(), site_, session, 3));
    const auto leased = mapping_.Acquire(Soon(), "w", std::chrono::seconds(300));
    ASSERT_OK(leased);
    ASSERT_TRUE(leased->has_value());
    ASSERT_EQ((*leased)->lease.session, session);
    Eigen::Matrix3d covariance;
    covariance << 0.02, 0.001, 0.002, 0.001, 0.03, -0.001, 0.002, -0.001, 0.01;
    slam::SlamDelta delta;
    delta.submaps = {{0, 1, {0.1 * seed, 0.2, 0.05}, true, "grid"}, {1, 1, {2.1, 0.3 * seed, -3.1}, true, "grid"}};
    delta.nodes = {{0, 1, 10, {1.0 / 3.0, seed, 0.1}, covariance, 0},
                   {1, 3, 30, {2.0 / 7.0, -seed, 3.1}, covariance, 1}};
    delta.loop_closures.push_back(
        {0, 0, 1, {1, 0, 0}, Eigen::Matrix3d::Identity(), slam::LoopClosureState::kAccepted, 0.5, 1.0, ""});
    delta.trajectory = {{1, 10, 0, {}}, {2, 20, 0, {0.5, 0.1, 0.2}}, {3, 30, 1, {}}};
    storage::NewRevision revision = RevisionOf({session.value()});
    revision.session = session;
    revision.source = storage::RevisionSource::kMapping;
    storage::MappingStep step = StepOf(delta, "checkpoint", 3);
    step.revision = &revision;
    step.final_state = storage::SessionState::kMapped;
    ASSERT_OK(mapping_.Commit(Soon(), (*leased)->lease, step));
    ASSERT_OK(mapping_.Release(Soon(), (*leased)->lease));
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
  // s1's passage into the lab.
  void Judge() {
    database_.Sql(
        "INSERT INTO door_verdicts (site_id, session_id, sequence, decision, map_id, x, y, yaw, covariance, evidence,"
        " reason, graph_version) VALUES ('campus', 's1', 3, 5, 'lab', 0.5, 0.25, 0.3, '{1,0,0,0,2,0,0,0,3}', '{}', '', "
        "1)");
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
    for (const char* query : {
             "SELECT map_id, display_name, redirect_map_id FROM maps",
             "SELECT map_id, x, y, yaw, covariance FROM graph_maps",
             "SELECT session_id, acknowledged_sequence, highest_sequence, laser_scans, odometry, payload_bytes,"
             " first_time_ns, last_time_ns, recorded_sequence, previous_session_id FROM sessions WHERE delete_time IS "
             "NULL",
             "SELECT session_id, sequence, time_ns, kind FROM session_records",
             "SELECT session_id, mapped_sequence, used, keyframes FROM mapping_checkpoints",
             "SELECT session_id, sequence, ordinal FROM door_comparisons",
             "SELECT session_id, map_id, state, initial_x, initial_y, initial_yaw, initial_covariance FROM sessions"
             " WHERE delete_time IS NULL",
             "SELECT session_id, submap_id, x, y, yaw, content FROM slam_submaps",
             "SELECT session_id, node_id, x, y, yaw, covariance FROM slam_nodes",
             "SELECT session_id, sequence, node_id, x, y, yaw FROM trajectory_points",
             "SELECT session_id, closure_id, x, y, yaw, state FROM slam_closures",
             "SELECT session_id, map_id, track::text FROM session_tracks",
             "SELECT session_id, sequence, map_id, x, y, yaw, covariance FROM door_verdicts",
             "SELECT robot_id, map_id, point::text, yaw, covariance FROM robot_poses",
             "SELECT ordinal, map_id, x, y FROM control_points",
             "SELECT link_point_id, kind, tag, direction_map_id, anchor_count, position::text, yaw FROM link_points",
             "SELECT link_point_id, map_id, ordinal, x, y, yaw, covariance FROM link_point_anchors",
             "SELECT link_point_id, map_id, kind, ordinal, sha256, x, y, yaw FROM link_point_evidence",
             "SELECT map_id, position, session_id, revision, raster_header FROM map_layers",
             "SELECT map_id, position, tile_row, tile_column, sha256 FROM map_layer_tiles",
             "SELECT map_id, content_sha256 FROM map_revisions JOIN maps USING (site_id, map_id)"
             " WHERE revision = current_revision",
         }) {
      all += std::string(query) + "\n";
      for (const std::string& row :
           database_.Sql("SELECT (q.*)::text FROM (" + std::string(query) + ") q ORDER BY 1")) {
        all += "  " + row + "\n";
      }
    }
    return all;
  }

  const Pose2 kHallLab{4, 5, M_PI / 2};  // T_hall_lab
  const MapId lab_{"lab"};
  const SessionId s1_{"s1"}, s2_{"s2"};
  const TestBlob image_{"image"};
  const storage::postgres::SiteLeaseStore leases_{*pool_};
  const storage::postgres::RearrangementStore store_{*pool_};
  storage::SiteLease lease_;
};

}  // namespace enfilade::testing
