// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <thread>

#include "tests/contract/storage/suite/mapping_fixture.h"

namespace enfilade::testing {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

TEST_F(MappingStoreTest, GivesBackTheSumOfAllSteps) {
  const SessionId session = SessionWithRecords("s1", 30);
  const storage::LeasedSession leased = AcquireOne();
  ASSERT_OK_AND_ASSIGN(const auto nothing, mapping_.Load(Soon(), site_, session));
  EXPECT_FALSE(nothing);
  slam::SlamMap expected;
  const std::string checkpoint("\0binary\xff", 8);
  const auto commit = [&](const slam::SlamDelta& delta, std::int64_t mapped) {
    storage::MappingStep step = StepOf(delta, checkpoint, mapped);
    step.counts = {1, 2, 3, 4, 5, mapped};
    ASSERT_OK(mapping_.Commit(Soon(), leased.lease, step));
    expected.Apply(delta);
    ASSERT_OK_AND_ASSIGN(const auto stored, mapping_.Load(Soon(), site_, session));
    ASSERT_TRUE(stored);
    ExpectEqual(stored->map, expected);
    EXPECT_EQ(stored->checkpoint, checkpoint);
    EXPECT_EQ(stored->mapped_sequence, mapped);
  };
  commit(FirstDelta(), 11);
  slam::SlamDelta second;
  second.submaps = {{0, 2, {0.5, 0, 0}, true, std::string(100'000, '\7')}, {1, 1, {3, 0, 0}, false, ""}};
  second.nodes = {NodeOf(2, 3.0)};
  second.nodes[0].submap = 1;
  second.trajectory = {{21, 3 * kNsPerSecond, 2, {0, 0, 0}}};
  commit(second, 21);
  slam::SlamDelta solved;  // poses move, the finished submap's content stays
  solved.submaps = {{0, 2, {0.6, 0, 0}, true, ""}};
  solved.nodes = {NodeOf(0, 0.0), NodeOf(1, 1.25), NodeOf(2, 2.75)};
  solved.loop_closures = {{0, 0, 1, {0.1, 0.2, 0.3}, MatrixOf(2), slam::LoopClosureState::kAccepted, 0.5, 1.5, ""}};
  commit(solved, 21);
  EXPECT_THAT(expected.submaps.at(0).content, SizeIs(100'000));
  ASSERT_OK_AND_ASSIGN(const storage::Session stored, sessions_.Get(Soon(), site_, session));
  EXPECT_EQ(stored.mapped_sequence, 21);
  EXPECT_EQ(stored.mapping_counts, (storage::MappingCounts{1, 2, 3, 4, 5, 21}));
}

TEST_F(MappingStoreTest, TheSameStepTwiceChangesNothing) {
  const SessionId session = SessionWithRecords("s1", 30);
  const storage::LeasedSession leased = AcquireOne();
  const TestBlob tile("tile");
  const storage::NewRevision revision = RevisionOf(session, tile);
  const slam::SlamDelta delta = FirstDelta();
  const std::vector<storage::BlobView> blobs = {tile.view()};
  storage::MappingStep step = StepOf(delta, "c", 11);
  step.revision = &revision;
  step.blobs = blobs;
  for (int i = 0; i < 3; ++i) {
    ASSERT_OK_AND_ASSIGN(const std::int64_t number, mapping_.Commit(Soon(), leased.lease, step));
    EXPECT_EQ(number, 1);
    EXPECT_THAT(LoadMap(session).trajectory, SizeIs(3));
  }
}

TEST_F(MappingStoreTest, RefusesStepsThatGoBack) {
  SessionWithRecords("s1", 30);
  const storage::LeasedSession leased = AcquireOne();
  ASSERT_OK(CommitStep(leased.lease, FirstDelta(), 20));
  EXPECT_STATUS(CommitStep(leased.lease, {}, 19), absl::StatusCode::kInvalidArgument, HasSubstr("20"));
}

TEST_F(MappingStoreTest, PublishesRevisionsAndClosesTheSession) {
  const SessionId session = SessionWithRecords("s1", 3);
  const storage::LeasedSession leased = AcquireOne();
  const TestBlob first_tile("first");
  const storage::NewRevision first = RevisionOf(session, first_tile);
  const slam::SlamDelta delta = FirstDelta();
  const std::vector<storage::BlobView> first_blobs = {first_tile.view()};
  storage::MappingStep step = StepOf(delta, "c", 3);
  step.revision = &first;
  step.blobs = first_blobs;
  ASSERT_OK_AND_ASSIGN(const std::int64_t number, mapping_.Commit(Soon(), leased.lease, step));
  EXPECT_EQ(number, 1);
  ASSERT_OK_AND_ASSIGN(const storage::Map mapping, maps_.Get(Soon(), site_, map_));
  EXPECT_EQ(mapping.state, storage::MapState::kMapping);

  const slam::SlamDelta nothing;
  storage::MappingStep last = StepOf(nothing, "c", 3);
  last.final_state = storage::SessionState::kMapped;
  EXPECT_STATUS(mapping_.Commit(Soon(), leased.lease, last), absl::StatusCode::kFailedPrecondition,
                HasSubstr("not finished"));
  ASSERT_OK(sessions_.Finish(Soon(), site_, session, 3));
  const TestBlob last_tile("last");
  const storage::NewRevision second = RevisionOf(session, last_tile);
  const std::vector<storage::BlobView> last_blobs = {last_tile.view()};
  last.revision = &second;
  last.blobs = last_blobs;
  ASSERT_OK_AND_ASSIGN(const std::int64_t last_number, mapping_.Commit(Soon(), leased.lease, last));
  EXPECT_EQ(last_number, 2);
  ASSERT_OK_AND_ASSIGN(const storage::Map ready, maps_.Get(Soon(), site_, map_));
  EXPECT_EQ(ready.state, storage::MapState::kReady);
  EXPECT_EQ(ready.etag, mapping.etag);
  ASSERT_OK_AND_ASSIGN(const storage::Session closed, sessions_.Get(Soon(), site_, session));
  EXPECT_EQ(closed.state, storage::SessionState::kMapped);
  ASSERT_OK_AND_ASSIGN(const storage::MapRevision stored, revisions_.Get(Soon(), site_, map_, 0));
  EXPECT_EQ(stored.session, session);
  ASSERT_OK(mapping_.Release(Soon(), leased.lease, 0));
  EXPECT_FALSE(FindsWork());
}

TEST_F(MappingStoreTest, AFailureIsOnRecordAndTheSessionGoesOnRecording) {
  const SessionId session = SessionWithRecords("s1", 3);
  const storage::LeasedSession leased = AcquireOne();
  const slam::SlamDelta nothing;
  storage::MappingStep step = StepOf(nothing, "", 2);
  step.final_state = storage::SessionState::kFailed;
  step.error = "record 3: it's \"odd\"";
  ASSERT_OK(mapping_.Commit(Soon(), leased.lease, step));
  ASSERT_OK(mapping_.Release(Soon(), leased.lease, 0));
  EXPECT_FALSE(FindsWork());
  EXPECT_OK(Append(session, {ScanRecord(4)}));
  ASSERT_OK_AND_ASSIGN(const storage::Session finished, sessions_.Finish(Soon(), site_, session, 4));
  EXPECT_EQ(finished.state, storage::SessionState::kFailed);
  EXPECT_EQ(finished.error, step.error);
  EXPECT_CODE(Append(session, {ScanRecord(5)}), absl::StatusCode::kFailedPrecondition);
}

TEST_F(MappingStoreTest, AStepThatCannotBeStoredWholeIsNotStoredAtAll) {
  const SessionId session = SessionWithRecords("s1", 3);
  const storage::LeasedSession leased = AcquireOne();
  const storage::NewRevision missing_tile = RevisionOf(session, TestBlob("never sent"));
  const slam::SlamDelta delta = FirstDelta();
  storage::MappingStep step = StepOf(delta, "c", 3);
  step.revision = &missing_tile;
  EXPECT_CODE(mapping_.Commit(Soon(), leased.lease, step), absl::StatusCode::kFailedPrecondition);
  slam::SlamDelta dangling = FirstDelta();
  dangling.trajectory.push_back({30, 4 * kNsPerSecond, 99, {0, 0, 0}});
  EXPECT_CODE(CommitStep(leased.lease, dangling, 3), absl::StatusCode::kFailedPrecondition);
  ASSERT_OK_AND_ASSIGN(const auto stored, mapping_.Load(Soon(), site_, session));
  EXPECT_FALSE(stored);
}

TEST_F(MappingStoreTest, TheTrajectoryFollowsTheNodes) {
  const SessionId session = SessionWithRecords("s1", 30);
  ASSERT_OK_AND_ASSIGN(const storage::Trajectory none, mapping_.ReadTrajectory(Soon(), site_, session));
  EXPECT_THAT(none.poses, IsEmpty());
  const storage::LeasedSession leased = AcquireOne();
  ASSERT_OK(CommitStep(leased.lease, FirstDelta(), 11));
  const auto expect_poses_of = [&](const slam::SlamMap& map, std::int64_t mapped) {
    ASSERT_OK_AND_ASSIGN(const storage::Trajectory trajectory, mapping_.ReadTrajectory(Soon(), site_, session));
    EXPECT_EQ(trajectory.mapped_sequence, mapped);
    const std::vector<slam::StampedPose> expected = slam::TrajectoryOf(map);
    ASSERT_EQ(trajectory.poses.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(trajectory.poses[i].time, expected[i].time);
      EXPECT_EQ(trajectory.poses[i].T_map_robot, expected[i].T_map_robot);
    }
  };
  slam::SlamMap map;
  map.Apply(FirstDelta());
  expect_poses_of(map, 11);
  slam::SlamDelta moved;
  moved.nodes = {NodeOf(1, 2.5)};
  ASSERT_OK(CommitStep(leased.lease, moved, 12));
  map.Apply(moved);
  expect_poses_of(map, 12);
  EXPECT_CODE(mapping_.ReadTrajectory(Soon(), site_, SessionId("s9")), absl::StatusCode::kNotFound);
}

TEST_F(MappingStoreTest, ListsKeyframesAsTheyAreNow) {
  const SessionId session = SessionWithRecords("s1", 30);
  ASSERT_OK_AND_ASSIGN(const auto none, mapping_.ListKeyframes(Soon(), site_, session));
  EXPECT_THAT(none, IsEmpty());
  const storage::LeasedSession leased = AcquireOne();
  ASSERT_OK(CommitStep(leased.lease, FirstDelta(), 11));
  slam::SlamDelta moved;
  moved.nodes = {NodeOf(1, 2.5)};
  ASSERT_OK(CommitStep(leased.lease, moved, 12));
  ASSERT_OK_AND_ASSIGN(const auto keyframes, mapping_.ListKeyframes(Soon(), site_, session));
  EXPECT_EQ(keyframes, (std::vector<slam::SlamNode>{NodeOf(0, 0.0), NodeOf(1, 2.5)}));
  ASSERT_OK_AND_ASSIGN(const auto missing, mapping_.ListKeyframes(Soon(), site_, SessionId("s9")));
  EXPECT_THAT(missing, IsEmpty());
}

TEST_F(MappingStoreTest, RecordingAndMappingOfOneSessionDoNotBlockEachOther) {
  const SessionId session = SessionWithRecords("s1", 1);
  const storage::LeasedSession leased = AcquireOne();
  absl::Status recorded;
  std::thread recorder([&] {
    for (std::int64_t sequence = 2; sequence <= 100 && recorded.ok(); ++sequence) {
      recorded = Append(session, {ScanRecord(sequence)}).status();
    }
  });
  absl::Status mapped;
  for (std::int64_t id = 0; id < 100 && mapped.ok(); ++id) {
    slam::SlamDelta delta;
    if (id == 0) delta.submaps = {{0, 1, {0, 0, 0}, false, ""}};
    delta.nodes = {NodeOf(id, 0.5)};
    mapped = CommitStep(leased.lease, delta, 1);
  }
  recorder.join();
  EXPECT_OK(recorded);
  EXPECT_OK(mapped);
  EXPECT_THAT(LoadMap(session).nodes, SizeIs(100));
}

TEST_F(MappingStoreTest, FindsTheKeyframeNearestInTime) {
  const SessionId session = SessionWithRecords("s1", 30);
  ASSERT_OK_AND_ASSIGN(const auto none, mapping_.FindKeyframe(Soon(), site_, session, 0));
  EXPECT_FALSE(none);
  const storage::LeasedSession leased = AcquireOne();
  slam::SlamDelta delta = FirstDelta();
  delta.nodes.push_back(NodeOf(2, 4.0));
  ASSERT_OK(CommitStep(leased.lease, delta, 11));  // at 1, 2 and 3 s
  struct Case {
    TimeNs time;
    double x;
  };
  for (const auto& [time, x] :
       {Case{0, 0.0}, Case{kNsPerSecond, 0.0}, Case{kNsPerSecond * 3 / 2 - 1, 0.0}, Case{kNsPerSecond * 3 / 2, 0.0},
        Case{kNsPerSecond * 3 / 2 + 1, 1.5}, Case{kNsPerSecond * 5 / 2 + 1, 4.0}, Case{100 * kNsPerSecond, 4.0}}) {
    ASSERT_OK_AND_ASSIGN(const auto keyframe, mapping_.FindKeyframe(Soon(), site_, session, time));
    ASSERT_TRUE(keyframe);
    EXPECT_EQ(keyframe->pose.x, x) << time;
  }
  ASSERT_OK_AND_ASSIGN(const auto found, mapping_.FindKeyframe(Soon(), site_, session, 3 * kNsPerSecond));
  EXPECT_EQ(found->covariance, NodeOf(2, 4.0).covariance);
}

TEST_F(MappingStoreTest, ALaterStepReplacesPointsOfTheTrajectory) {
  const SessionId session = SessionWithRecords("s1", 30);
  const storage::LeasedSession leased = AcquireOne();
  ASSERT_OK(CommitStep(leased.lease, FirstDelta(), 11));
  slam::SlamDelta later;
  later.trajectory = {{5, kNsPerSecond * 3 / 2, 1, {0.25, 0, 0}}, {12, 3 * kNsPerSecond, 1, {0.5, 0, 0}}};
  ASSERT_OK(CommitStep(leased.lease, later, 12));
  const slam::SlamMap map = LoadMap(session);
  std::vector<std::int64_t> sequences;
  for (const slam::TrajectoryPoint& point : map.trajectory) sequences.push_back(point.sequence);
  EXPECT_EQ(sequences, (std::vector<std::int64_t>{1, 5, 11, 12}));
  EXPECT_EQ(map.trajectory[1].node, 1);
}

TEST_F(MappingStoreTest, ALostLeaseStoresNothingOfAStepWithARevision) {
  const SessionId session = SessionWithRecords("s1", 3);
  const storage::LeasedSession lost = AcquireOne("first", milliseconds(1));
  std::this_thread::sleep_for(milliseconds(5));
  AcquireOne("second");
  const TestBlob tile("tile");
  const storage::NewRevision revision = RevisionOf(session, tile);
  const std::vector<storage::BlobView> blobs = {tile.view()};
  const slam::SlamDelta delta = FirstDelta();
  storage::MappingStep step = StepOf(delta, "c", 3);
  step.revision = &revision;
  step.blobs = blobs;
  EXPECT_CODE(mapping_.Commit(Soon(), lost.lease, step), absl::StatusCode::kAborted);
  EXPECT_CODE(revisions_.Get(Soon(), site_, map_, 0), absl::StatusCode::kNotFound);
  EXPECT_EQ(backend_->CountBlobs(), 0);
  ASSERT_OK_AND_ASSIGN(const auto stored, mapping_.Load(Soon(), site_, session));
  EXPECT_FALSE(stored);
}

TEST_F(MappingStoreTest, AStepFromOldLayersIsRefusedWhole) {
  const SessionId session = SessionWithRecords("s1", 3);
  const storage::LeasedSession leased = AcquireOne();
  ASSERT_OK_AND_ASSIGN(const auto seen, revisions_.ReadLayersBeside(Soon(), site_, map_, session));
  const TestBlob imported("imported");
  storage::NewRevision import;
  import.source = storage::RevisionSource::kImport;
  import.content_sha256 = imported.sha256();
  import.tiles = {{ {0, 0}, imported.sha256() }};
  ASSERT_OK(revisions_.Add(Soon(), site_, map_, import, {imported.view()}));
  const TestBlob tile("tile");
  storage::NewRevision revision = RevisionOf(session, tile);
  revision.layers_version = seen.version;
  const std::vector<storage::BlobView> blobs = {tile.view()};
  const slam::SlamDelta delta = FirstDelta();
  storage::MappingStep step = StepOf(delta, "c", 3);
  step.revision = &revision;
  step.blobs = blobs;
  const absl::Status refused = mapping_.Commit(Soon(), leased.lease, step).status();
  EXPECT_CODE(refused, absl::StatusCode::kAborted);
  EXPECT_TRUE(storage::AreLayersChanged(refused)) << "so that the worker keeps its lease and repeats the step";
  ASSERT_OK_AND_ASSIGN(const auto stored, mapping_.Load(Soon(), site_, session));
  EXPECT_FALSE(stored);
  ASSERT_OK_AND_ASSIGN(const auto now, revisions_.ReadLayersBeside(Soon(), site_, map_, session));
  revision.layers_version = now.version;
  ASSERT_OK_AND_ASSIGN(const std::int64_t number, mapping_.Commit(Soon(), leased.lease, step));
  EXPECT_EQ(number, 2);
}

}  // namespace
}  // namespace enfilade::testing
