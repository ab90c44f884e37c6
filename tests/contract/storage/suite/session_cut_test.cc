// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "storage/graph/rearrangement_store.h"
#include "tests/contract/storage/suite/contract_test.h"
#include "tests/contract/storage/suite/rearrangement_fixture.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
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
