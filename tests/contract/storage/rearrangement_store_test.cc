// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/rearrange/rearrangement_store.h"

#include <chrono>
#include <cmath>

#include "core/base/sha256.h"
#include "storage/graph/door_verdict_store.h"
#include "storage/postgres/graph/site_lease_store.h"
#include "storage/sites/maintenance.h"
#include "tests/contract/storage/store_test.h"
#include "tests/support/pose_matchers.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr auto kTtl = std::chrono::seconds(300);

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
    const auto lease = leases_.Acquire(Soon(), site_, "me", kTtl);
    EXPECT_OK(lease);
    lease_ = lease->value_or(storage::SiteLease());
  }

  // Two keyframes in two submaps, with a closure and a track, and a raster of one tile.
  void MapSession(const SessionId& session, double seed) {
    ASSERT_OK(Append(session, {ScanRecord(1), ScanRecord(2), ScanRecord(3)}));
    ASSERT_OK(sessions_.Finish(Soon(), site_, session, 3));
    const auto leased = mapping_.Acquire(Soon(), "w", kTtl);
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
             "SELECT session_id, map_id, state, initial_x, initial_y, initial_yaw, initial_covariance FROM sessions",
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

TEST_F(RearrangementStoreTest, MergesTwoMaps) {
  const auto before = mapping_.ReadTrajectory(Soon(), site_, s2_);
  const std::int64_t version = Version();
  const auto merged = store_.Apply(Soon(), lease_, Merge());
  ASSERT_OK(merged);
  EXPECT_EQ(merged->version_before, version);
  EXPECT_EQ(merged->version_after, version + 1);
  EXPECT_EQ(Version(), version + 1);
  EXPECT_EQ(merged->reason, "one room");
  EXPECT_THAT(merged->moves, ElementsAre(rearrange::SessionMove{s2_, map_, kHallLab}));

  const auto session = sessions_.Get(Soon(), site_, s2_);
  EXPECT_EQ(session->map, map_);
  EXPECT_THAT(session->entry.T_map_robot->pose, PoseNear(kHallLab * Pose2{0.5, 0.25, 0.3}, 1e-12, 1e-12));
  EXPECT_NEAR(session->entry.T_map_robot->covariance(0, 0), 0.04, 1e-12);
  const auto after = mapping_.ReadTrajectory(Soon(), site_, s2_);
  ASSERT_EQ(after->poses.size(), before->poses.size());
  for (std::size_t i = 0; i < after->poses.size(); ++i) {
    EXPECT_THAT(after->poses[i].T_map_robot, PoseNear(kHallLab * before->poses[i].T_map_robot, 1e-12, 1e-12));
  }
  EXPECT_EQ(database_.SqlValue("SELECT map_id FROM session_tracks WHERE session_id = 's2'"), "hall");
  EXPECT_EQ(database_.SqlValue("SELECT round(ST_X(ST_StartPoint(track))::numeric, 6) FROM session_tracks"
                               " WHERE session_id = 's2'"),
            "2.000000");
  EXPECT_EQ(database_.SqlValue("SELECT map_id FROM door_verdicts"), "hall");
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM control_points WHERE map_id = 'hall'"), "2");
  const auto pose = robot_poses_.Get(Soon(), site_, robot_);
  EXPECT_EQ(pose->map, map_);
  EXPECT_THAT(pose->T_map_robot.pose, PoseNear(kHallLab * Pose2{1, 1, 0.1}, 1e-12, 1e-12));
}

TEST_F(RearrangementStoreTest, LinkPointsAndTheirEvidenceFollow) {
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  EXPECT_STATUS(link_points_.Get(Soon(), site_, LinkPointId("door")), absl::StatusCode::kNotFound, HasSubstr("door"));
  const auto gate = link_points_.Get(Soon(), site_, LinkPointId("gate"));
  ASSERT_OK(gate);
  ASSERT_THAT(gate->point.anchors, SizeIs(2));
  EXPECT_THAT(gate->point.FindAnchor(map_)->T_map_place, PoseNear(kHallLab * Pose2{3, 1, 0.4}, 1e-12, 1e-12));
  ASSERT_TRUE(gate->T_world_place);
  EXPECT_THAT(gate->T_world_place->pose, PoseNear(kHallLab * Pose2{3, 1, 0.4}, 1e-9, 1e-9));
  const auto evidence = link_points_.ListEvidence(Soon(), site_, {LinkPointId("gate")});
  ASSERT_THAT(*evidence, SizeIs(1));
  EXPECT_EQ(evidence->front().map, map_);
  EXPECT_THAT(*evidence->front().T_map_robot, PoseNear(kHallLab * Pose2{2, 1, 0.4}, 1e-12, 1e-12));
  EXPECT_TRUE(link_points_.Get(Soon(), site_, LinkPointId("seen"))->point.is_candidate());
}

TEST_F(RearrangementStoreTest, LayersAndRevisionsFollow) {
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  const auto layers = revisions_.ReadLayersBeside(Soon(), site_, map_, SessionId("none"));
  ASSERT_THAT(layers->below, SizeIs(2));
  EXPECT_EQ(layers->below[1].session, s2_);
  EXPECT_EQ(layers->below[1].raster.tiles[0].sha256, TestBlob("s2 moved").sha256());
  const auto revision = revisions_.Get(Soon(), site_, map_, 0);
  EXPECT_EQ(revision->number, 2);
  EXPECT_EQ(revision->content_sha256, Sha256("s1s2 moved"));
}

TEST_F(RearrangementStoreTest, OldNamesLeadToTheOtherMap) {
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  EXPECT_EQ(maps_.Get(Soon(), site_, lab_)->id, map_);
  EXPECT_EQ(maps_.GetByDisplayName(Soon(), site_, "Lab")->id, map_);
  EXPECT_THAT(*maps_.List(Soon(), site_, storage::PageRequest{}), SizeIs(2));
  EXPECT_EQ(revisions_.Get(Soon(), site_, lab_, 0)->map, map_);
  EXPECT_EQ(revisions_.Get(Soon(), site_, lab_, 1)->map, lab_) << "revisions are immutable";
  storage::Map old = *maps_.Get(Soon(), site_, map_);
  old.id = lab_;
  EXPECT_STATUS(maps_.Update(Soon(), old), absl::StatusCode::kNotFound, HasSubstr("lab"));
  EXPECT_STATUS(maps_.Delete(Soon(), site_, lab_, 0, false), absl::StatusCode::kNotFound, HasSubstr("lab"));
  EXPECT_STATUS(link_points_.Create(Soon(), MakeLinkPoint(site_, "late", {MakeAnchor("lab", 1, 1)}), ""),
                absl::StatusCode::kNotFound, HasSubstr("lab"));
  // A robot that still knows the old name.
  storage::Session late = MakeSession(site_, SessionId("s9"), robot_, lab_);
  late.entry.T_map_robot = PoseWithCovariance{{1, 0, 0}, Eigen::Vector3d(1, 2, 3).asDiagonal()};
  ASSERT_OK(sessions_.Create(Soon(), late, ""));
  EXPECT_EQ(sessions_.Get(Soon(), site_, late.id)->map, map_);
  EXPECT_THAT(sessions_.Get(Soon(), site_, late.id)->entry.T_map_robot->pose,
              PoseNear(kHallLab * Pose2{1, 0, 0}, 1e-12, 1e-12));
  ASSERT_OK(robot_poses_.Report(Soon(), {site_, robot_, lab_, {}, {{2, 0, 0}, Eigen::Matrix3d::Identity()}, 100, 0}));
  EXPECT_THAT(robot_poses_.Get(Soon(), site_, robot_)->T_map_robot.pose,
              PoseNear(kHallLab * Pose2{2, 0, 0}, 1e-12, 1e-12));
}

TEST_F(RearrangementStoreTest, TheGraphLosesTheMap) {
  const std::int64_t before = Version();
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  const auto changes = graph_.ReadChanges(Soon(), site_, before);
  ASSERT_OK(changes);
  EXPECT_THAT(changes->removed_maps, ElementsAre(lab_));
  EXPECT_THAT(changes->removed_link_points, ElementsAre(LinkPointId("door")));
  const auto versions = graph_.ListVersions(Soon(), site_, 0, 1);
  EXPECT_EQ(versions->front().cause, storage::GraphCause::kRearranged);
  EXPECT_EQ(versions->front().resource, "rearrangements/merge");
}

TEST_F(RearrangementStoreTest, UndoRestoresEverything) {
  const std::string before = Everything();
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  EXPECT_NE(Everything(), before);
  const std::int64_t version = Version();
  const auto undone = store_.Undo(Soon(), lease_, rearrange::RearrangementId("merge"));
  ASSERT_OK(undone);
  EXPECT_EQ(Everything(), before);
  EXPECT_EQ(undone->version_undone, version + 1);
  EXPECT_TRUE(undone->undo_time);
  EXPECT_EQ(revisions_.Get(Soon(), site_, map_, 0)->number, 3) << "revisions only grow";
  const auto changes = graph_.ReadChanges(Soon(), site_, version);
  EXPECT_THAT(changes->removed_maps, IsEmpty());
  EXPECT_STATUS(store_.Undo(Soon(), lease_, rearrange::RearrangementId("merge")), absl::StatusCode::kFailedPrecondition,
                HasSubstr("already"));
  // And again.
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge("again")));
  EXPECT_EQ(sessions_.Get(Soon(), site_, s2_)->map, map_);
}

TEST_F(RearrangementStoreTest, SplitsAMapAndUndoesIt) {
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  const std::string before = Everything();
  const std::int64_t version = Version();
  ASSERT_OK(store_.Apply(Soon(), lease_, Split()));
  EXPECT_EQ(Version(), version + 1);
  EXPECT_EQ(sessions_.Get(Soon(), site_, s2_)->map, MapId("annex"));
  EXPECT_EQ(maps_.Get(Soon(), site_, MapId("annex"))->display_name, "Map 1");
  EXPECT_EQ(revisions_.Get(Soon(), site_, map_, 0)->content_sha256, Sha256("s1 alone"));
  EXPECT_EQ(revisions_.Get(Soon(), site_, MapId("annex"), 0)->content_sha256, Sha256("s2 split"));
  const auto places = graph_.GetPlaces(Soon(), site_, {MapId("annex")});
  ASSERT_THAT(*places, SizeIs(1));
  EXPECT_THAT(places->front().T_world_map.pose, PoseNear(Inverse(Pose2{1, 2, 0.5}), 1e-12, 1e-12));
  ASSERT_OK(store_.Undo(Soon(), lease_, rearrange::RearrangementId("split")));
  EXPECT_EQ(maps_.Get(Soon(), site_, MapId("annex"))->id, map_);
  database_.Sql("DELETE FROM map_layer_tiles WHERE map_id = 'annex'");
  database_.Sql("DELETE FROM maps WHERE map_id = 'annex'");
  EXPECT_EQ(Everything(), before);
  // Undone in the other order as they were done.
  ASSERT_OK(store_.Undo(Soon(), lease_, rearrange::RearrangementId("merge")));
  EXPECT_EQ(maps_.Get(Soon(), site_, lab_)->id, lab_);
}

TEST_F(RearrangementStoreTest, RefusesToUndoWhatWasChangedSince) {
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  const rearrange::RearrangementId id("merge");
  ASSERT_OK(link_points_.Delete(Soon(), site_, LinkPointId("seen"), 0));
  const std::string before = Everything();
  EXPECT_STATUS(store_.Undo(Soon(), lease_, id), absl::StatusCode::kFailedPrecondition, HasSubstr("link point seen"));
  EXPECT_EQ(Everything(), before);
  EXPECT_STATUS(store_.Undo(Soon(), lease_, rearrange::RearrangementId("none")), absl::StatusCode::kNotFound,
                HasSubstr("rearrangements/none"));
}

TEST_F(RearrangementStoreTest, RefusesToUndoOnceItsSessionIsGone) {
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  ASSERT_OK(sessions_.Delete(Soon(), site_, s2_));
  EXPECT_STATUS(store_.Undo(Soon(), lease_, rearrange::RearrangementId("merge")), absl::StatusCode::kFailedPrecondition,
                HasSubstr("session s2"));
}

TEST_F(RearrangementStoreTest, RefusesToUndoASplitIntoWhichAnotherHasCome) {
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  ASSERT_OK(store_.Apply(Soon(), lease_, Split()));
  ASSERT_OK(sessions_.Create(Soon(), MakeSession(site_, SessionId("s3"), robot_, MapId("annex")), ""));
  EXPECT_STATUS(store_.Undo(Soon(), lease_, rearrange::RearrangementId("split")), absl::StatusCode::kFailedPrecondition,
                HasSubstr("session s3 has come into map annex"));
}

TEST_F(RearrangementStoreTest, BlobsThatUndoingNeedsAreKept) {
  storage::RearrangementChange change = Merge();
  change.rearrangement.link_points.erase(change.rearrangement.link_points.begin());
  change.rearrangement.removed_link_points.emplace_back("gate");
  ASSERT_OK(store_.Apply(Soon(), lease_, change));
  storage::Maintenance maintenance(*pool_);
  ASSERT_OK(maintenance.CollectBlobs(Soon(), std::chrono::seconds(0), 1000));
  ASSERT_OK(store_.Undo(Soon(), lease_, change.id));
  EXPECT_THAT(*link_points_.ListEvidence(Soon(), site_, {LinkPointId("gate")}), SizeIs(1));
}

TEST_F(RearrangementStoreTest, RefusesSessionsThatAreNotMapped) {
  ASSERT_OK(sessions_.Create(Soon(), MakeSession(site_, SessionId("s3"), robot_, lab_), ""));
  const std::string before = Everything();
  EXPECT_STATUS(store_.Apply(Soon(), lease_, Merge()), absl::StatusCode::kFailedPrecondition,
                HasSubstr("sites/campus/sessions/s3 is still in map lab"));
  storage::RearrangementChange change = Merge();
  change.rearrangement.moves.push_back({SessionId("s3"), map_, kHallLab});
  EXPECT_STATUS(store_.Apply(Soon(), lease_, change), absl::StatusCode::kFailedPrecondition,
                HasSubstr("sites/campus/sessions/s3 is still recording"));
  ASSERT_OK(Append(SessionId("s3"), {ScanRecord(1)}));
  ASSERT_OK(sessions_.Finish(Soon(), site_, SessionId("s3"), 1));
  EXPECT_STATUS(store_.Apply(Soon(), lease_, change), absl::StatusCode::kFailedPrecondition,
                HasSubstr("sites/campus/sessions/s3 is still being mapped"));
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM rearrangements"), "0");
}

TEST_F(RearrangementStoreTest, RefusesWhatDoesNotFit) {
  const std::string before = Everything();
  storage::RearrangementChange change = Merge();
  change.rearrangement.link_points.pop_back();
  EXPECT_STATUS(store_.Apply(Soon(), lease_, change), absl::StatusCode::kFailedPrecondition,
                HasSubstr("linkPoints/seen still has an anchor in map lab"));
  change = Merge();
  change.rearrangement.redirects = {{map_, lab_, {}}};
  change.rearrangement.moves = {{s1_, lab_, {}}};
  change.rearrangement.link_points.clear();
  EXPECT_STATUS(store_.Apply(Soon(), lease_, change), absl::StatusCode::kFailedPrecondition, HasSubstr("world frame"));
  change = Merge();
  change.rearrangement.moves[0].to = MapId("nowhere");
  EXPECT_STATUS(store_.Apply(Soon(), lease_, change), absl::StatusCode::kNotFound, HasSubstr("maps/nowhere"));
  change = Merge();
  change.rearrangement.removed_link_points.emplace_back("none");
  EXPECT_STATUS(store_.Apply(Soon(), lease_, change), absl::StatusCode::kNotFound, HasSubstr("linkPoints/none"));
  change = Merge();
  ++change.rasters[0].layers_version;
  EXPECT_TRUE(storage::AreLayersChanged(store_.Apply(Soon(), lease_, change).status()));
  change = Merge();
  --change.graph_version;
  EXPECT_STATUS(store_.Apply(Soon(), lease_, change), absl::StatusCode::kAborted, HasSubstr("decide again"));
  storage::SiteLease lost = lease_;
  ++lost.token;
  EXPECT_STATUS(store_.Apply(Soon(), lost, Merge()), absl::StatusCode::kAborted, HasSubstr("lost the lease"));
  EXPECT_EQ(Everything(), before);
}

TEST_F(RearrangementStoreTest, TwoAtOnceOneWins) {
  const storage::RearrangementChange first = Merge("first"), second = Merge("second");
  ASSERT_OK(store_.Apply(Soon(), lease_, first));
  EXPECT_STATUS(store_.Apply(Soon(), lease_, second), absl::StatusCode::kAborted, HasSubstr("decide again"));
  EXPECT_THAT(*store_.List(Soon(), site_, 0, 10), SizeIs(1));
}

TEST_F(RearrangementStoreTest, ListsTheNewestFirst) {
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  ASSERT_OK(store_.Apply(Soon(), lease_, Split()));
  const auto all = store_.List(Soon(), site_, 0, 10);
  ASSERT_THAT(*all, SizeIs(2));
  EXPECT_EQ(all->front().id.value(), "split");
  EXPECT_THAT(all->front().new_maps, ElementsAre(MapId("annex")));
  EXPECT_THAT(*store_.List(Soon(), site_, all->front().version_after, 10), SizeIs(1));
  EXPECT_EQ(store_.Get(Soon(), site_, rearrange::RearrangementId("merge"))->redirects.front().from, lab_);
}

TEST_F(RearrangementStoreTest, ChainsOfRedirectsAreFollowed) {
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  ASSERT_OK(store_.Apply(Soon(), lease_, Split()));
  storage::RearrangementChange change;
  change.id = rearrange::RearrangementId("third");
  change.graph_version = Version();
  change.rearrangement.moves = {{s2_, MapId("yard"), {0, 0, 1}}};
  change.rearrangement.redirects = {{MapId("annex"), MapId("yard"), {0, 0, 1}}};
  change.rearrangement.removed_link_points = {LinkPointId("arch")};
  change.rasters = {Raster("yard", "s2", {"s2 yard"})};
  ASSERT_OK(store_.Apply(Soon(), lease_, change));
  EXPECT_EQ(maps_.Get(Soon(), site_, MapId("annex"))->id, MapId("yard"));
  EXPECT_STATUS(store_.Undo(Soon(), lease_, rearrange::RearrangementId("split")), absl::StatusCode::kFailedPrecondition,
                HasSubstr("changed since"));
  ASSERT_OK(store_.Undo(Soon(), lease_, change.id));
  ASSERT_OK(store_.Undo(Soon(), lease_, rearrange::RearrangementId("split")));
}

TEST_F(RearrangementStoreTest, DeletingTheMapDeletesWhatLeadsToIt) {
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  ASSERT_OK(maps_.Delete(Soon(), site_, map_, 0, true));
  EXPECT_STATUS(maps_.Get(Soon(), site_, lab_), absl::StatusCode::kNotFound, HasSubstr("lab"));
  ASSERT_OK(sites_.Delete(Soon(), site_, 0, true));
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM rearrangements"), "0");
}

}  // namespace
}  // namespace enfilade::testing
