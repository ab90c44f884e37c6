// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "storage/graph/rearrangement_store.h"
#include "tests/contract/storage/suite/contract_test.h"
#include "tests/contract/storage/suite/rearrangement_fixture.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Key;
using ::testing::SizeIs;

// The lab's session s2 is cut; s3 followed it.
class SessionCutTest : public RearrangementFixture<StoreContractTest> {
 protected:
  SessionCutTest() {
    storage::Session third = MakeSession(site_, SessionId("s3"), robot_, std::nullopt);
    third.entry.previous = s2_;
    EXPECT_OK(sessions_.Create(Soon(), third, ""));
  }
  const SessionId rest_{"s2b"};
};

TEST_F(SessionCutTest, ASessionThatIsCreatedLaterFollowsTheLastPiece) {
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Cut()));
  storage::Session later = MakeSession(site_, SessionId("s4"), robot_, std::nullopt);
  later.entry.previous = s2_;
  ASSERT_OK_AND_ASSIGN(const storage::Session created, sessions_.Create(Soon(), later, ""));
  EXPECT_EQ(created.entry.previous, rest_);
  later.id = SessionId("s5");
  later.entry.previous = rest_;
  EXPECT_EQ(sessions_.Create(Soon(), later, "")->entry.previous, rest_);
  later.id = SessionId("s6");
  later.entry.previous = SessionId("none");
  EXPECT_CODE(sessions_.Create(Soon(), later, ""), absl::StatusCode::kNotFound);
  ASSERT_OK(rearrangements_.Undo(Soon(), lease_, rearrange::RearrangementId("cut")));
  EXPECT_EQ(sessions_.Get(Soon(), site_, SessionId("s4"))->entry.previous, s2_);
}

TEST_F(SessionCutTest, TheRestIsASessionOfItsOwn) {
  const auto before = mapping_.ReadTrajectory(Soon(), site_, s2_);
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Cut()));
  ASSERT_OK_AND_ASSIGN(const storage::Session head, sessions_.Get(Soon(), site_, s2_));
  ASSERT_OK_AND_ASSIGN(const storage::Session rest, sessions_.Get(Soon(), site_, rest_));
  EXPECT_EQ(head.map, lab_);
  EXPECT_EQ(head.highest_sequence, 2) << "cut at the keyframe";
  EXPECT_EQ(head.record_counts.laser_scans, 2);
  EXPECT_EQ(rest.map, MapId("annex"));
  EXPECT_EQ(rest.state, storage::SessionState::kMapped);
  EXPECT_EQ(rest.record_counts.laser_scans, 1);
  EXPECT_EQ(rest.entry.previous, s2_);
  EXPECT_EQ(rest.mapped_sequence, 3);
  EXPECT_EQ(rest.first_time, rest.last_time);
  EXPECT_LT(*head.last_time, *rest.first_time);
  EXPECT_EQ(sessions_.Get(Soon(), site_, SessionId("s3"))->entry.previous, rest_);

  const auto first = mapping_.ReadTrajectory(Soon(), site_, s2_);
  const auto second = mapping_.ReadTrajectory(Soon(), site_, rest_);
  ASSERT_THAT(first->poses, SizeIs(2));
  ASSERT_THAT(second->poses, SizeIs(1));
  EXPECT_EQ(first->poses[1].T_map_robot, before->poses[1].T_map_robot);
  EXPECT_THAT(second->poses[0].T_map_robot, PoseNear(Pose2{1, 2, 0.5} * before->poses[2].T_map_robot, 1e-12, 1e-12));

  ASSERT_OK_AND_ASSIGN(const auto records, records_.Read(Soon(), site_, rest_, 1, 1 << 20));
  ASSERT_THAT(records, SizeIs(1));
  EXPECT_EQ(records[0].sequence, 3);
  EXPECT_THAT(*records_.Read(Soon(), site_, s2_, 1, 1 << 20), SizeIs(2));
  for (const SessionId& part : {s2_, rest_}) {
    EXPECT_THAT((*mapping_.Load(Soon(), site_, part))->map.loop_closures, IsEmpty())
        << "the loop closure was across the cut";
  }
}

TEST_F(SessionCutTest, UndoMakesItWhole) {
  const std::string before = Everything();
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Cut()));
  ASSERT_OK(rearrangements_.Undo(Soon(), lease_, rearrange::RearrangementId("cut")));
  EXPECT_STATUS(sessions_.Get(Soon(), site_, rest_), absl::StatusCode::kNotFound, HasSubstr("s2b"));
  EXPECT_EQ(maps_.Get(Soon(), site_, MapId("annex"))->id, lab_);
  EXPECT_EQ(Everything(), before);
}

// A session of the lab with a keyframe at the records 1, 2, 4 and 5, the first two of one submap, is cut into three.
class SeveralCutsTest : public SessionCutTest {
 protected:
  SeveralCutsTest() {
    EXPECT_OK(sessions_.Create(Soon(), MakeSession(site_, long_, robot_, lab_), ""));
    const Eigen::Matrix3d covariance = Eigen::Vector3d(0.01, 0.02, 0.03).asDiagonal();
    slam::SlamDelta delta;
    delta.submaps = {{0, 1, {0.1, 0.2, 0.3}, true, "grid"}, {1, 1, {4.0, 0.2, 0.1}, true, "grid"}};
    delta.nodes = {{0, 1, 10, {1, 0, 0}, covariance, 0},
                   {1, 2, 20, {2, 0, 0}, covariance, 0},
                   {2, 4, 40, {4, 0, 0}, covariance, 1},
                   {3, 5, 50, {5, 0, 0}, covariance, 1}};
    for (const auto& [id, submap, node] : {std::array{0, 0, 1}, std::array{1, 0, 3}, std::array{2, 1, 3}}) {
      delta.loop_closures.push_back(
          {id, submap, node, {1, 0, 0}, Eigen::Matrix3d::Identity(), slam::LoopClosureState::kAccepted, 0.5, 1.0, ""});
    }
    delta.trajectory = {{1, 10, 0, {}}, {2, 20, 1, {}}, {3, 30, 1, {0.5, 0, 0}}, {4, 40, 2, {}}, {5, 50, 3, {}}};
    MapScans(long_, 5, delta);
    storage::Session next = MakeSession(site_, SessionId("next"), robot_, std::nullopt);
    next.entry.previous = long_;
    EXPECT_OK(sessions_.Create(Soon(), next, ""));
  }
  storage::RearrangementChange CutTwice(std::int64_t first, std::int64_t second) {
    storage::RearrangementChange change;
    change.id = rearrange::RearrangementId("cuts");
    rearrange::Rearrangement& cut = change.rearrangement;
    cut.new_maps = {{MapId("annex"), "Map", 0, Environment::kIndoor, ""}};
    cut.cuts = {{long_, first, SessionId("middle")}, {long_, second, SessionId("end")}};
    cut.moves = {{SessionId("middle"), MapId("annex"), {1, 2, 0.5}}};
    change.graph_version = Version();
    change.rasters = {Raster("annex", "middle", {"middle"}), Raster("lab", "end", {"long head", "long end"})};
    return change;
  }
  std::vector<std::int64_t> RecordsOf(const std::string& session) {
    std::vector<std::int64_t> sequences;
    const auto records = records_.Read(Soon(), site_, SessionId(session), 1, 1 << 20);
    EXPECT_OK(records);
    for (const sensor::Record& record : *records) {
      sequences.push_back(record.sequence);
    }
    return sequences;
  }
  const SessionId long_{"long"};
};

TEST_F(SeveralCutsTest, EachRestEndsAtTheNextCut) {
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, CutTwice(2, 3)));
  EXPECT_THAT(RecordsOf("long"), ElementsAre(1));
  EXPECT_THAT(RecordsOf("middle"), ElementsAre(2, 3));
  EXPECT_THAT(RecordsOf("end"), ElementsAre(4, 5)) << "cut at the keyframe";
  ASSERT_OK_AND_ASSIGN(const storage::Session head, sessions_.Get(Soon(), site_, long_));
  ASSERT_OK_AND_ASSIGN(const storage::Session middle, sessions_.Get(Soon(), site_, SessionId("middle")));
  ASSERT_OK_AND_ASSIGN(const storage::Session end, sessions_.Get(Soon(), site_, SessionId("end")));
  EXPECT_EQ(middle.entry.previous, long_);
  EXPECT_EQ(end.entry.previous, SessionId("middle"));
  EXPECT_EQ(sessions_.Get(Soon(), site_, SessionId("next"))->entry.previous, SessionId("end"));
  EXPECT_EQ(middle.map, MapId("annex"));
  EXPECT_EQ(end.map, lab_);
  EXPECT_EQ(head.highest_sequence, 1);
  EXPECT_EQ(middle.highest_sequence, 3);
  EXPECT_EQ(middle.mapped_sequence, 3);
  EXPECT_EQ(middle.record_counts.laser_scans, 2);
  EXPECT_EQ(end.mapped_sequence, 5);
  EXPECT_LT(head.create_time, middle.create_time);
  EXPECT_LT(middle.create_time, end.create_time);

  const slam::SlamMap first = (*mapping_.Load(Soon(), site_, long_))->map;
  const slam::SlamMap second = (*mapping_.Load(Soon(), site_, middle.id))->map;
  const slam::SlamMap third = (*mapping_.Load(Soon(), site_, end.id))->map;
  EXPECT_THAT(first.nodes, ElementsAre(Key(0)));
  EXPECT_THAT(second.nodes, ElementsAre(Key(1)));
  EXPECT_THAT(third.nodes, ElementsAre(Key(2), Key(3)));
  EXPECT_THAT(first.submaps, ElementsAre(Key(0)));
  EXPECT_THAT(second.submaps, ElementsAre(Key(0))) << "it has keyframes of both";
  EXPECT_THAT(third.submaps, ElementsAre(Key(1)));
  EXPECT_THAT(first.loop_closures, IsEmpty());
  EXPECT_THAT(second.loop_closures, ElementsAre(Key(0)));
  EXPECT_THAT(third.loop_closures, ElementsAre(Key(2)));
  EXPECT_THAT(second.trajectory, SizeIs(2));

  storage::Session later = MakeSession(site_, SessionId("later"), robot_, std::nullopt);
  later.entry.previous = long_;
  EXPECT_EQ(sessions_.Create(Soon(), later, "")->entry.previous, end.id) << "it follows the last piece";
}

TEST_F(SeveralCutsTest, UndoMakesItWhole) {
  const std::string before = Everything();
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, CutTwice(2, 4)));
  EXPECT_NE(Everything(), before);
  ASSERT_OK_AND_ASSIGN(const auto undone, rearrangements_.Undo(Soon(), lease_, rearrange::RearrangementId("cuts")));
  EXPECT_THAT(undone.cuts, SizeIs(2));
  EXPECT_EQ(Everything(), before);
  EXPECT_EQ(sessions_.Get(Soon(), site_, SessionId("next"))->entry.previous, long_);
}

TEST_F(SeveralCutsTest, APieceWithoutKeyframesIsRefused) {
  const std::string before = Everything();
  EXPECT_STATUS(rearrangements_.Apply(Soon(), lease_, CutTwice(3, 4)), absl::StatusCode::kFailedPrecondition,
                HasSubstr("nothing to cut off"));
  EXPECT_EQ(Everything(), before);
}

TEST_F(SessionCutTest, TheRobotMaySendAndFinishAgain) {
  ASSERT_OK(rearrangements_.Apply(Soon(), lease_, Cut()));
  EXPECT_OK(sessions_.Finish(Soon(), site_, s2_, 3)) << "as it was recorded";
  ASSERT_OK_AND_ASSIGN(const auto again, Append(s2_, {ScanRecord(2), ScanRecord(3)}));
  EXPECT_EQ(again.acknowledged_sequence, 3);
  EXPECT_THAT(*records_.Read(Soon(), site_, s2_, 1, 1 << 20), SizeIs(2));
  EXPECT_THAT(*records_.Read(Soon(), site_, rest_, 1, 1 << 20), SizeIs(1));
  EXPECT_STATUS(sessions_.Finish(Soon(), site_, s2_, 4), absl::StatusCode::kFailedPrecondition, HasSubstr("4"));
}

TEST_F(SessionCutTest, RefusesWhatCannotBeCut) {
  const std::string before = Everything();
  EXPECT_STATUS(rearrangements_.Apply(Soon(), lease_, Cut(4)), absl::StatusCode::kFailedPrecondition,
                HasSubstr("nothing to cut off"));
  storage::RearrangementChange change = Cut();
  change.rearrangement.cuts[0].rest = s1_;
  change.rearrangement.moves.clear();
  change.rearrangement.new_maps.clear();
  change.rasters.clear();
  EXPECT_STATUS(rearrangements_.Apply(Soon(), lease_, change), absl::StatusCode::kAlreadyExists, HasSubstr("rest"));
  change.rearrangement.cuts[0] = {SessionId("none"), 2, rest_};
  EXPECT_STATUS(rearrangements_.Apply(Soon(), lease_, change), absl::StatusCode::kNotFound, HasSubstr("sessions/none"));
  EXPECT_EQ(Everything(), before);
  backend_->ExpireRecords(site_, s2_);
  EXPECT_STATUS(rearrangements_.Apply(Soon(), lease_, Cut()), absl::StatusCode::kFailedPrecondition,
                HasSubstr("deleted"));
}

}  // namespace
}  // namespace enfilade::testing
