// SPDX-License-Identifier: Apache-2.0
#include "tests/contract/storage/rearrangement_fixture.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

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

TEST_F(RearrangementStoreTest, WhatUndoingNeedsIsDeletedInPortionsWhenItIsOld) {
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

  const std::string before = Everything();
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
  EXPECT_EQ(Everything(), before) << "only undoing is lost";

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

TEST_F(RearrangementStoreTest, BlobsOfWhatCannotBeUndoneAreCollected) {
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

}  // namespace
}  // namespace enfilade::testing
