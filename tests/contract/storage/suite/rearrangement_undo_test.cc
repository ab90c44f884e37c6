// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "storage/graph/rearrangement_store.h"
#include "tests/contract/storage/suite/contract_test.h"
#include "tests/contract/storage/suite/rearrangement_fixture.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

using RearrangementUndoTest = RearrangementFixture<StoreContractTest>;

TEST_F(RearrangementUndoTest, UndoRestoresEverything) {
  const std::string before = Everything();
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Merge()));
  EXPECT_NE(Everything(), before);
  const std::int64_t version = Version();
  const auto undone = rearrangements_.Undo(Soon(), lease_, rearrange::RearrangementId("merge"));
  ASSERT_OK(undone);
  EXPECT_EQ(Everything(), before);
  EXPECT_EQ(undone->version_undone, version + 1);
  EXPECT_TRUE(undone->undo_time);
  ASSERT_OK_AND_ASSIGN(const storage::MapRevision restored, revisions_.Get(Soon(), site_, map_, 0));
  EXPECT_EQ(restored.number, 3) << "revisions only grow";
  ASSERT_OK_AND_ASSIGN(const auto tiles, revisions_.ReadTiles(Soon(), restored, std::nullopt, 1 << 20));
  EXPECT_EQ(static_cast<std::int64_t>(tiles.size()), restored.tile_count) << "with its tiles";
  EXPECT_GT(restored.tile_count, 0);
  const auto changes = graph_.ReadChanges(Soon(), site_, version);
  EXPECT_THAT(changes->removed_maps, IsEmpty());
  EXPECT_STATUS(rearrangements_.Undo(Soon(), lease_, rearrange::RearrangementId("merge")),
                absl::StatusCode::kFailedPrecondition, HasSubstr("already"));
  // And again.
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Merge("again")));
  EXPECT_EQ(sessions_.Get(Soon(), site_, s2_)->map, map_);
}

TEST_F(RearrangementUndoTest, SplitsAMapAndUndoesIt) {
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Merge()));
  const std::string before = Everything();
  const std::int64_t version = Version();
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Split()));
  EXPECT_EQ(Version(), version + 1);
  EXPECT_EQ(sessions_.Get(Soon(), site_, s2_)->map, MapId("annex"));
  EXPECT_EQ(maps_.Get(Soon(), site_, MapId("annex"))->display_name, "Map 1");
  EXPECT_EQ(revisions_.Get(Soon(), site_, map_, 0)->content_sha256, Sha256("s1 alone"));
  EXPECT_EQ(revisions_.Get(Soon(), site_, MapId("annex"), 0)->content_sha256, Sha256("s2 split"));
  const auto places = graph_.GetPlaces(Soon(), site_, {MapId("annex")});
  ASSERT_THAT(*places, SizeIs(1));
  EXPECT_THAT(places->front().T_world_map.pose, PoseNear(Inverse(Pose2{1, 2, 0.5}), 1e-12, 1e-12));
  ASSERT_OK(rearrangements_.Undo(Soon(), lease_, rearrange::RearrangementId("split")));
  EXPECT_EQ(maps_.Get(Soon(), site_, MapId("annex"))->id, map_);
  EXPECT_EQ(Everything(), before);
  // Undone in the other order as they were done.
  ASSERT_OK(rearrangements_.Undo(Soon(), lease_, rearrange::RearrangementId("merge")));
  EXPECT_EQ(maps_.Get(Soon(), site_, lab_)->id, lab_);
}

TEST_F(RearrangementUndoTest, MovesASessionWithinItsMapAndUndoesIt) {
  const std::string before = Everything();
  const auto poses = mapping_.ReadTrajectory(Soon(), site_, s2_);
  const storage::RearrangementChange shift = Shift();
  const Pose2 T_new_old = shift.rearrangement.moves[0].T_to_from;
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, shift));
  const auto session = sessions_.Get(Soon(), site_, s2_);
  EXPECT_EQ(session->map, lab_);
  EXPECT_THAT(session->entry.T_map_robot->pose, PoseNear(T_new_old * Pose2{0.5, 0.25, 0.3}, 1e-12, 1e-12));
  const auto moved = mapping_.ReadTrajectory(Soon(), site_, s2_);
  ASSERT_EQ(moved->poses.size(), poses->poses.size());
  for (std::size_t i = 0; i < moved->poses.size(); ++i) {
    EXPECT_THAT(moved->poses[i].T_map_robot, PoseNear(T_new_old * poses->poses[i].T_map_robot, 1e-12, 1e-12));
  }
  EXPECT_THAT(robot_poses_.Get(Soon(), site_, robot_)->T_map_robot.pose,
              PoseNear(T_new_old * Pose2{1, 1, 0.1}, 1e-12, 1e-12));
  const auto layers = revisions_.ReadLayersBeside(Soon(), site_, lab_, SessionId("none"));
  ASSERT_THAT(layers->below, SizeIs(1)) << "its layer of before is gone";
  EXPECT_EQ(layers->below[0].raster.tiles[0].sha256, TestBlob("s2 moved").sha256());
  // What is the map's own stays where it is.
  const auto gate = link_points_.Get(Soon(), site_, LinkPointId("gate"));
  EXPECT_THAT(gate->point.FindAnchor(lab_)->T_map_place, PoseNear(Pose2{3, 1, 0.4}, 1e-12, 1e-12));
  const auto evidence = link_points_.ListEvidence(Soon(), site_, {LinkPointId("gate")});
  EXPECT_THAT(*evidence->front().T_map_robot, PoseNear(Pose2{2, 1, 0.4}, 1e-12, 1e-12));
  ASSERT_OK(rearrangements_.Undo(Soon(), lease_, shift.id));
  EXPECT_EQ(Everything(), before);
}

TEST_F(RearrangementUndoTest, RefusesToUndoWhatWasChangedSince) {
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Merge()));
  const rearrange::RearrangementId id("merge");
  ASSERT_OK(link_points_.Delete(Soon(), site_, LinkPointId("seen"), 0));
  const std::string before = Everything();
  EXPECT_STATUS(rearrangements_.Undo(Soon(), lease_, id), absl::StatusCode::kFailedPrecondition,
                HasSubstr("link point seen"));
  EXPECT_EQ(Everything(), before);
  EXPECT_STATUS(rearrangements_.Undo(Soon(), lease_, rearrange::RearrangementId("none")), absl::StatusCode::kNotFound,
                HasSubstr("rearrangements/none"));
}

TEST_F(RearrangementUndoTest, RefusesToUndoOnceItsSessionIsGone) {
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Merge()));
  ASSERT_OK(sessions_.Delete(Soon(), site_, s2_));
  EXPECT_STATUS(rearrangements_.Undo(Soon(), lease_, rearrange::RearrangementId("merge")),
                absl::StatusCode::kFailedPrecondition, HasSubstr("session s2"));
}

TEST_F(RearrangementUndoTest, RefusesToUndoASplitIntoWhichAnotherHasCome) {
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Merge()));
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Split()));
  ASSERT_OK(sessions_.Create(Soon(), MakeSession(site_, SessionId("s3"), robot_, MapId("annex")), ""));
  EXPECT_STATUS(rearrangements_.Undo(Soon(), lease_, rearrange::RearrangementId("split")),
                absl::StatusCode::kFailedPrecondition, HasSubstr("session s3 has come into map annex"));
}

TEST_F(RearrangementUndoTest, ChainsOfRedirectsAreFollowed) {
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Merge()));
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Split()));
  storage::RearrangementChange change;
  change.id = rearrange::RearrangementId("third");
  change.graph_version = Version();
  change.rearrangement.moves = {{s2_, MapId("yard"), {0, 0, 1}}};
  change.rearrangement.redirects = {{MapId("annex"), MapId("yard"), {0, 0, 1}}};
  change.rearrangement.removed_link_points = {LinkPointId("arch")};
  change.rasters = {Raster("yard", "s2", {"s2 yard"})};
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, change));
  EXPECT_EQ(maps_.Get(Soon(), site_, MapId("annex"))->id, MapId("yard"));
  EXPECT_STATUS(rearrangements_.Undo(Soon(), lease_, rearrange::RearrangementId("split")),
                absl::StatusCode::kFailedPrecondition, HasSubstr("changed since"));
  ASSERT_OK(rearrangements_.Undo(Soon(), lease_, change.id));
  ASSERT_OK(rearrangements_.Undo(Soon(), lease_, rearrange::RearrangementId("split")));
}

// Layers that were overlaid beforehand are looked at one by one again where one has come or gone.
TEST_F(RearrangementUndoTest, RunsOfLayersDoNotOutliveThem) {
  const auto layers = [&] { return revisions_.ReadRunsBeside(Soon(), site_, map_, SessionId("none"), 0.05); };
  const auto add_run = [&] {
    const auto beside = layers();
    ASSERT_OK(beside);
    ASSERT_THAT(beside->below, SizeIs(2));
    storage::NewLayerRun run{beside->below[0].first, beside->below[1].last, 0.05, beside->version, {}, {}};
    run.content = RasterOf({"both"});
    ASSERT_OK(revisions_.AddRun(Soon(), site_, map_, run));
    ASSERT_THAT(layers()->below, SizeIs(1));
  };
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Merge()));
  ASSERT_NO_FATAL_FAILURE(add_run());
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Split()));  // s2 leaves
  ASSERT_THAT(layers()->below, SizeIs(1));
  EXPECT_EQ(layers()->below[0].session, s1_);
  const std::int64_t split = layers()->version;
  ASSERT_OK(rearrangements_.Undo(Soon(), lease_, rearrange::RearrangementId("split")));
  ASSERT_NO_FATAL_FAILURE(add_run());
  EXPECT_GT(layers()->version, split) << "a revision of the layers that were there meanwhile is refused";
  ASSERT_OK(rearrangements_.Undo(Soon(), lease_, rearrange::RearrangementId("merge")));
  ASSERT_THAT(layers()->below, SizeIs(1));
  EXPECT_EQ(layers()->below[0].session, s1_);
}

}  // namespace
}  // namespace enfilade::testing
