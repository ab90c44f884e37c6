// SPDX-License-Identifier: Apache-2.0
// What a rearrangement does to rows that no interface of the contract suite shows.
#include <gmock/gmock.h>

#include "storage/graph/door_verdict_store.h"
#include "storage/sessions/loop_closure_store.h"
#include "storage/sites/maintenance.h"
#include "tests/contract/storage/postgres_rearrangements.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

TEST_F(RearrangementRowsTest, TracksAndVerdictsFollow) {
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  EXPECT_EQ(database_.SqlValue("SELECT map_id FROM session_tracks WHERE session_id = 's2'"), "hall");
  EXPECT_EQ(database_.SqlValue("SELECT round(ST_X(ST_StartPoint(track))::numeric, 6) FROM session_tracks"
                               " WHERE session_id = 's2'"),
            "2.000000");
  EXPECT_EQ(database_.SqlValue("SELECT map_id FROM door_verdicts"), "hall");
}

TEST_F(RearrangementRowsTest, UndoRestoresEveryRow) {
  const std::string before = AllRows();
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  EXPECT_NE(AllRows(), before);
  ASSERT_OK(store_.Undo(Soon(), lease_, rearrange::RearrangementId("merge")));
  EXPECT_EQ(AllRows(), before);
}

TEST_F(RearrangementRowsTest, UndoingASplitRestoresEveryRow) {
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  const std::string before = AllRows();
  ASSERT_OK(store_.Apply(Soon(), lease_, Split()));
  ASSERT_OK(store_.Undo(Soon(), lease_, rearrange::RearrangementId("split")));
  database_.Sql("DELETE FROM map_layer_tiles WHERE map_id = 'annex'");
  database_.Sql("DELETE FROM maps WHERE map_id = 'annex'");
  EXPECT_EQ(AllRows(), before);
}

TEST_F(RearrangementRowsTest, RefusalsChangeNoRow) {
  const std::string before = AllRows();
  storage::RearrangementChange change = Merge();
  ++change.rasters[0].layers_version;
  EXPECT_TRUE(storage::AreLayersChanged(store_.Apply(Soon(), lease_, change).status()));
  EXPECT_EQ(AllRows(), before);
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM rearrangements"), "0");
}

TEST_F(RearrangementRowsTest, DeletingTheSiteDeletesItsRearrangements) {
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  ASSERT_OK(maps_.Delete(Soon(), site_, map_, 0, true));
  DeleteSite(site_);
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM rearrangements"), "0");
}

TEST_F(RearrangementRowsTest, RevisionsThatUndoingNeedsAreKept) {
  const storage::Maintenance maintenance(*pool_);
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  ASSERT_OK_AND_ASSIGN(storage::Site site, sites_.Get(Soon(), site_));
  site.revision_retention = storage::RevisionRetention{.newest = 1};
  ASSERT_OK(sites_.Update(Soon(), site));
  ASSERT_OK_AND_ASSIGN(const storage::MaintenancePortion portion, maintenance.DeleteRevisions(Soon(), 1000));
  EXPECT_GE(portion.looked_at, 1);
  EXPECT_EQ(portion.deleted, 0);
  ASSERT_OK(store_.Undo(Soon(), lease_, rearrange::RearrangementId("merge")));
  ASSERT_OK_AND_ASSIGN(const storage::MapRevision restored, revisions_.Get(Soon(), site_, map_, 0));
  ASSERT_OK_AND_ASSIGN(const auto tiles, revisions_.ReadTiles(Soon(), restored, std::nullopt, 1 << 20));
  EXPECT_EQ(static_cast<std::int64_t>(tiles.size()), restored.tile_count);
  // When it cannot be undone any more, they go.
  database_.Sql("UPDATE rearrangements SET create_time = now() - interval '1 hour'");
  ASSERT_OK(maintenance.DeleteExpiredUndo(Soon(), std::chrono::seconds(60), 1000));
  database_.Sql("UPDATE revision_reviews SET due_time = now()");
  ASSERT_OK_AND_ASSIGN(const storage::MaintenancePortion rest, maintenance.DeleteRevisions(Soon(), 1000));
  EXPECT_GT(rest.deleted, 0);
}

TEST_F(RearrangementRowsTest, BlobsThatUndoingNeedsAreKept) {
  storage::RearrangementChange change = Merge();
  change.rearrangement.link_points.erase(change.rearrangement.link_points.begin());
  change.rearrangement.removed_link_points.emplace_back("gate");
  ASSERT_OK(store_.Apply(Soon(), lease_, change));
  storage::Maintenance maintenance(*pool_);
  ASSERT_OK(maintenance.CollectBlobs(Soon(), std::chrono::seconds(0), 1000));
  ASSERT_OK(store_.Undo(Soon(), lease_, change.id));
  EXPECT_THAT(*link_points_.ListEvidence(Soon(), site_, {LinkPointId("gate")}), SizeIs(1));
}

TEST_F(RearrangementRowsTest, BlobsOfWhatCannotBeUndoneAreCollected) {
  storage::RearrangementChange change = Merge();
  change.rearrangement.link_points.erase(change.rearrangement.link_points.begin());
  change.rearrangement.removed_link_points.emplace_back("gate");
  ASSERT_OK(store_.Apply(Soon(), lease_, change));
  const storage::Maintenance maintenance(*pool_);
  ASSERT_OK(maintenance.CollectBlobs(Soon(), std::chrono::seconds(0), 1000));
  ASSERT_OK(blobs_.Get(Soon(), site_, image_.sha256()));
  ASSERT_OK(maintenance.DeleteExpiredUndo(Soon(), std::chrono::seconds(0), 1000));
  ASSERT_OK(maintenance.CollectBlobs(Soon(), std::chrono::seconds(0), 1000));
  EXPECT_CODE(blobs_.Get(Soon(), site_, image_.sha256()).status(), absl::StatusCode::kNotFound);
}

TEST_F(RearrangementRowsTest, WhatUndoingNeedsIsDeletedInPortionsWhenItIsOld) {
  ASSERT_OK(store_.Apply(Soon(), lease_, Merge()));
  ASSERT_OK(store_.Apply(Soon(), lease_, Split()));
  database_.Sql("UPDATE rearrangements SET create_time = now() - interval '31 days' WHERE rearrangement_id = 'merge'");
  const auto count = [&](const std::string& table, const std::string& id) {
    return std::stoll(database_.SqlValue("SELECT count(*) FROM " + table + " WHERE rearrangement_id = '" + id + "'"));
  };
  const auto images = count("rearrangement_images", "merge"), blobs = count("rearrangement_blobs", "merge");
  const auto kept = count("rearrangement_images", "split");
  ASSERT_GT(images, 4);
  ASSERT_GT(blobs, 0);
  const storage::Maintenance maintenance(*pool_);
  constexpr std::chrono::hours kMonth{30 * 24};
  const rearrange::RearrangementId merge("merge");
  EXPECT_FALSE(store_.Get(Soon(), site_, merge)->undo_expired);

  const std::string before = AllRows();
  ASSERT_OK_AND_ASSIGN(const std::int64_t portion, maintenance.DeleteExpiredUndo(Soon(), kMonth, 3));
  EXPECT_EQ(portion, 3);
  EXPECT_EQ(count("rearrangement_images", "merge"), images - 3);
  EXPECT_STATUS(store_.Undo(Soon(), lease_, merge), absl::StatusCode::kFailedPrecondition,
                HasSubstr("rearrangements/merge can no longer be undone"))
      << "not even by what is left";
  ASSERT_OK_AND_ASSIGN(const std::int64_t rest, maintenance.DeleteExpiredUndo(Soon(), kMonth, 1000));
  EXPECT_EQ(rest, images + blobs - 3);
  ASSERT_OK_AND_ASSIGN(const std::int64_t nothing, maintenance.DeleteExpiredUndo(Soon(), kMonth, 1000));
  EXPECT_EQ(nothing, 0);
  EXPECT_EQ(count("rearrangement_images", "merge") + count("rearrangement_blobs", "merge"), 0);
  EXPECT_EQ(count("rearrangement_images", "split"), kept);
  EXPECT_EQ(AllRows(), before) << "only undoing is lost";

  ASSERT_OK_AND_ASSIGN(const auto listed, store_.List(Soon(), site_, 0, 10));
  ASSERT_THAT(listed, SizeIs(2));
  EXPECT_FALSE(listed[0].undo_expired);
  EXPECT_TRUE(listed[1].undo_expired);
  EXPECT_THAT(listed[1].moves, SizeIs(1));
  EXPECT_STATUS(store_.Undo(Soon(), lease_, merge), absl::StatusCode::kFailedPrecondition,
                HasSubstr("can no longer be undone"));
  EXPECT_EQ(maps_.Get(Soon(), site_, lab_)->id, map_) << "names still lead there";
  ASSERT_OK(store_.Undo(Soon(), lease_, rearrange::RearrangementId("split")));
}

TEST_F(RearrangementRowsTest, ACutDividesVerdictsAndUndoingItReturnsThem) {
  database_.Sql(
      "INSERT INTO door_verdicts (site_id, session_id, sequence, decision, evidence, reason, graph_version)"
      " VALUES ('campus', 's2', 3, 2, '{1}', '', 1)");
  database_.Sql(
      "INSERT INTO door_comparisons (site_id, session_id, sequence, ordinal, link_point_id, map_id, images_agree,"
      " inlier_share, clouds_agree, accepted, reason) VALUES ('campus', 's2', 3, 1, 'gate', 'yard', false, 0, false,"
      " false, '')");
  const std::string before = AllRows();
  ASSERT_OK(store_.Apply(Soon(), lease_, Cut()));
  const storage::DoorVerdictStore verdicts(*pool_);
  ASSERT_OK_AND_ASSIGN(const auto judged, verdicts.List(Soon(), site_, SessionId("s2b"), 0, 10));
  ASSERT_THAT(judged, SizeIs(1));
  EXPECT_THAT(judged[0].comparisons, SizeIs(1));
  ASSERT_OK(store_.Undo(Soon(), lease_, rearrange::RearrangementId("cut")));
  database_.Sql("DELETE FROM map_layers WHERE map_id = 'annex'");
  database_.Sql("DELETE FROM maps WHERE map_id = 'annex'");
  EXPECT_EQ(AllRows(), before);
}

TEST_F(RearrangementRowsTest, UndoingTwoCutsOfASessionRestoresEveryRow) {
  database_.Sql(
      "INSERT INTO slam_nodes (site_id, session_id, node_id, sequence, time_ns, x, y, yaw, covariance, submap_id)"
      " SELECT site_id, session_id, 7, 2, 20, x, y, yaw, covariance, submap_id FROM slam_nodes"
      " WHERE session_id = 's2' AND node_id = 0");
  database_.Sql("UPDATE trajectory_points SET node_id = 7 WHERE session_id = 's2' AND sequence = 2");
  database_.Sql(
      "INSERT INTO door_verdicts (site_id, session_id, sequence, decision, evidence, reason, graph_version)"
      " VALUES ('campus', 's2', 2, 2, '{1}', '', 1), ('campus', 's2', 3, 2, '{1}', '', 1)");
  const std::string before = AllRows();
  storage::RearrangementChange change = Cut();
  change.rearrangement.cuts.push_back({s2_, 3, SessionId("s2c")});
  ASSERT_OK(store_.Apply(Soon(), lease_, change));
  EXPECT_THAT(database_.Sql("SELECT session_id || sequence FROM door_verdicts WHERE session_id LIKE 's2%' ORDER BY 1"),
              ElementsAre("s2b2", "s2c3"));
  EXPECT_THAT(database_.Sql("SELECT session_id || sequence FROM slam_nodes WHERE session_id LIKE 's2%' ORDER BY 1"),
              ElementsAre("s21", "s2b2", "s2c3"));
  ASSERT_OK(store_.Undo(Soon(), lease_, rearrange::RearrangementId("cut")));
  database_.Sql("DELETE FROM map_layers WHERE map_id = 'annex'");
  database_.Sql("DELETE FROM maps WHERE map_id = 'annex'");
  EXPECT_EQ(AllRows(), before);
}

TEST_F(RearrangementRowsTest, ASubmapWithKeyframesOnBothSidesIsInBoth) {
  database_.Sql("UPDATE slam_nodes SET submap_id = 0 WHERE session_id = 's2'");
  ASSERT_OK(store_.Apply(Soon(), lease_, Cut()));
  EXPECT_THAT(database_.Sql("SELECT session_id || submap_id FROM slam_submaps WHERE session_id LIKE 's2%' ORDER BY 1"),
              ElementsAre("s20", "s21", "s2b0"));
}

TEST_F(RearrangementRowsTest, LoopClosuresOfACutSessionStayAsTheyAre) {
  database_.Sql("UPDATE slam_closures SET node_id = 0 WHERE session_id = 's2'");
  ASSERT_OK(store_.Apply(Soon(), lease_, Cut()));
  const storage::LoopClosureStore closures(*pool_);
  ASSERT_THAT(*closures.List(Soon(), site_, s2_, -1, 10), SizeIs(1));
  EXPECT_STATUS(closures.SetSuspended(Soon(), site_, s2_, 0, true), absl::StatusCode::kFailedPrecondition,
                HasSubstr("cut in two"));
}

}  // namespace
}  // namespace enfilade::testing
