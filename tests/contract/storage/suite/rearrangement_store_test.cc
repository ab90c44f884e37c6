// SPDX-License-Identifier: Apache-2.0
#include "storage/graph/rearrangement_store.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include "tests/contract/storage/suite/contract_test.h"
#include "tests/contract/storage/suite/rearrangement_fixture.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

using RearrangementStoreTest = RearrangementFixture<StoreContractTest>;

TEST_F(RearrangementStoreTest, MergesTwoMaps) {
  const auto before = mapping_.ReadTrajectory(Soon(), site_, s2_);
  const std::int64_t version = Version();
  const auto merged = rearrangements_.Apply(Soon(), lease_, Merge());
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
  ASSERT_OK_AND_ASSIGN(const auto points, graph_.GetControlPoints(Soon(), site_));
  ASSERT_THAT(points, SizeIs(2));
  EXPECT_EQ(points[1].map, map_);
  EXPECT_NEAR((points[1].position - kHallLab * Eigen::Vector2d(1, 2)).norm(), 0.0, 1e-12);
  const auto pose = robot_poses_.Get(Soon(), site_, robot_);
  EXPECT_EQ(pose->map, map_);
  EXPECT_THAT(pose->T_map_robot.pose, PoseNear(kHallLab * Pose2{1, 1, 0.1}, 1e-12, 1e-12));
}

TEST_F(RearrangementStoreTest, LinkPointsAndTheirEvidenceFollow) {
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Merge()));
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
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Merge()));
  const auto layers = revisions_.ReadLayersBeside(Soon(), site_, map_, SessionId("none"));
  ASSERT_THAT(layers->below, SizeIs(2));
  EXPECT_EQ(layers->below[1].session, s2_);
  EXPECT_EQ(layers->below[1].raster.tiles[0].sha256, TestBlob("s2 moved").sha256());
  const auto revision = revisions_.Get(Soon(), site_, map_, 0);
  EXPECT_EQ(revision->number, 2);
  EXPECT_EQ(revision->content_sha256, Sha256("s1s2 moved"));
}

TEST_F(RearrangementStoreTest, OldNamesLeadToTheOtherMap) {
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Merge()));
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
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Merge()));
  const auto changes = graph_.ReadChanges(Soon(), site_, before);
  ASSERT_OK(changes);
  EXPECT_THAT(changes->removed_maps, ElementsAre(lab_));
  EXPECT_THAT(changes->removed_link_points, ElementsAre(LinkPointId("door")));
  const auto versions = graph_.ListVersions(Soon(), site_, 0, 1);
  EXPECT_EQ(versions->front().cause, storage::GraphCause::kRearranged);
  EXPECT_EQ(versions->front().resource, "rearrangements/merge");
}

TEST_F(RearrangementStoreTest, WatchersAreToldOnce) {
  const std::unique_ptr<storage::GraphListener> listener = *graph_.Listen(Soon());
  const auto await = [&] { return *listener->Await(storage::CallContext::WithTimeout(std::chrono::seconds(1))); };
  storage::RearrangementChange refused = Merge("refused");
  ++refused.rasters[0].layers_version;
  ASSERT_FALSE(rearrangements_.Apply(Soon(), lease_, refused).ok());
  ASSERT_OK_AND_ASSIGN(const auto merged, rearrangements_.Apply(Soon(), lease_, Merge()));
  const std::vector<storage::GraphListener::Change> told = await();
  ASSERT_THAT(told, SizeIs(1)) << "and not of what was refused";
  EXPECT_EQ(told[0].site, site_);
  EXPECT_EQ(told[0].version, merged.version_after);
  ASSERT_OK_AND_ASSIGN(const auto undone, rearrangements_.Undo(Soon(), lease_, merged.id));
  const std::vector<storage::GraphListener::Change> again = await();
  ASSERT_THAT(again, SizeIs(1));
  EXPECT_EQ(again[0].version, undone.version_undone);
  EXPECT_THAT(await(), IsEmpty());
}

TEST_F(RearrangementStoreTest, ARedirectLeadsThroughAllOthers) {
  storage::CallContext context = Soon();
  context.actor = "ann";
  ASSERT_OK_AND_ASSIGN(const auto merged, rearrangements_.Apply(context, lease_, Merge()));
  EXPECT_EQ(merged.actor, "ann");
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Split()));
  ASSERT_OK(rearrangements_.Undo(Soon(), lease_, rearrange::RearrangementId("split")));
  const auto resolve = [&](const std::string& map) { return *rearrangements_.Resolve(Soon(), site_, MapId(map)); };
  EXPECT_EQ(resolve("lab").to, map_);
  EXPECT_THAT(resolve("lab").T_to_from, PoseNear(kHallLab, 1e-12, 1e-12));
  EXPECT_EQ(resolve("annex").to, map_) << "what was undone leads back";
  EXPECT_THAT(resolve("annex").T_to_from, PoseNear(Inverse(Pose2{1, 2, 0.5}), 1e-12, 1e-12));
  for (const char* map : {"hall", "nowhere"})
    EXPECT_EQ(resolve(map), (rearrange::MapRedirect{MapId(map), MapId(map), {}}));
}

TEST_F(RearrangementStoreTest, RefusesSessionsThatAreNotMapped) {
  ASSERT_OK(sessions_.Create(Soon(), MakeSession(site_, SessionId("s3"), robot_, lab_), ""));
  const std::string before = Everything();
  EXPECT_STATUS(rearrangements_.Apply(Soon(), lease_, Merge()), absl::StatusCode::kFailedPrecondition,
                HasSubstr("sites/campus/sessions/s3 is still in map lab"));
  storage::RearrangementChange change = Merge();
  change.rearrangement.moves.push_back({SessionId("s3"), map_, kHallLab});
  EXPECT_STATUS(rearrangements_.Apply(Soon(), lease_, change), absl::StatusCode::kFailedPrecondition,
                HasSubstr("sites/campus/sessions/s3 is still recording"));
  ASSERT_OK(Append(SessionId("s3"), {ScanRecord(1)}));
  ASSERT_OK(sessions_.Finish(Soon(), site_, SessionId("s3"), 1));
  EXPECT_STATUS(rearrangements_.Apply(Soon(), lease_, change), absl::StatusCode::kFailedPrecondition,
                HasSubstr("sites/campus/sessions/s3 is still being mapped"));
  EXPECT_THAT(*rearrangements_.List(Soon(), site_, 0, 10), IsEmpty());
}

TEST_F(RearrangementStoreTest, RefusesWhatDoesNotFit) {
  const std::string before = Everything();
  storage::RearrangementChange change = Merge();
  change.rearrangement.link_points.pop_back();
  EXPECT_STATUS(rearrangements_.Apply(Soon(), lease_, change), absl::StatusCode::kFailedPrecondition,
                HasSubstr("linkPoints/seen still has an anchor in map lab"));
  change = Merge();
  change.rearrangement.redirects = {{map_, lab_, {}}};
  change.rearrangement.moves = {{s1_, lab_, {}}};
  change.rearrangement.link_points.clear();
  EXPECT_STATUS(rearrangements_.Apply(Soon(), lease_, change), absl::StatusCode::kFailedPrecondition,
                HasSubstr("world frame"));
  change = Merge();
  change.rearrangement.moves[0].to = MapId("nowhere");
  EXPECT_STATUS(rearrangements_.Apply(Soon(), lease_, change), absl::StatusCode::kNotFound, HasSubstr("maps/nowhere"));
  change = Merge();
  change.rearrangement.removed_link_points.emplace_back("none");
  EXPECT_STATUS(rearrangements_.Apply(Soon(), lease_, change), absl::StatusCode::kNotFound,
                HasSubstr("linkPoints/none"));
  change = Merge();
  ++change.rasters[0].layers_version;
  EXPECT_TRUE(storage::AreLayersChanged(rearrangements_.Apply(Soon(), lease_, change).status()));
  change = Merge();
  --change.graph_version;
  EXPECT_STATUS(rearrangements_.Apply(Soon(), lease_, change), absl::StatusCode::kAborted, HasSubstr("decide again"));
  storage::SiteLease lost = lease_;
  ++lost.token;
  EXPECT_STATUS(rearrangements_.Apply(Soon(), lost, Merge()), absl::StatusCode::kAborted, HasSubstr("lost the lease"));
  EXPECT_EQ(Everything(), before);
}

TEST_F(RearrangementStoreTest, TwoAtOnceOneWins) {
  const storage::RearrangementChange first = Merge("first"), second = Merge("second");
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, first));
  EXPECT_STATUS(rearrangements_.Apply(Soon(), lease_, second), absl::StatusCode::kAborted, HasSubstr("decide again"));
  EXPECT_THAT(*rearrangements_.List(Soon(), site_, 0, 10), SizeIs(1));
}

TEST_F(RearrangementStoreTest, OfManyThreadsOneMakesItAndTheOthersDecideAgain) {
  const std::int64_t version = Version();
  std::vector<storage::RearrangementChange> changes;
  for (const char* id : {"a", "b", "c", "d"}) changes.push_back(Merge(id));
  std::vector<absl::Status> results(changes.size());
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    threads.emplace_back([&, i] { results[i] = rearrangements_.Apply(Soon(), lease_, changes[i]).status(); });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(std::count_if(results.begin(), results.end(), [](const absl::Status& one) { return one.ok(); }), 1);
  for (const absl::Status& one : results) EXPECT_TRUE(one.ok() || absl::IsAborted(one)) << one;
  EXPECT_EQ(Version(), version + 1);
  EXPECT_THAT(*rearrangements_.List(Soon(), site_, 0, 10), SizeIs(1));
}

TEST_F(RearrangementStoreTest, ListsTheNewestFirst) {
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Merge()));
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Split()));
  const auto all = rearrangements_.List(Soon(), site_, 0, 10);
  ASSERT_THAT(*all, SizeIs(2));
  EXPECT_EQ(all->front().id.value(), "split");
  EXPECT_THAT(all->front().new_maps, ElementsAre(MapId("annex")));
  EXPECT_THAT(*rearrangements_.List(Soon(), site_, all->front().version_after, 10), SizeIs(1));
  EXPECT_EQ(rearrangements_.Get(Soon(), site_, rearrange::RearrangementId("merge"))->redirects.front().from, lab_);
}

TEST_F(RearrangementStoreTest, DeletingTheMapDeletesWhatLeadsToIt) {
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Merge()));
  ASSERT_OK(maps_.Delete(Soon(), site_, map_, 0, true));
  EXPECT_STATUS(maps_.Get(Soon(), site_, lab_), absl::StatusCode::kNotFound, HasSubstr("lab"));
}

}  // namespace
}  // namespace enfilade::testing
