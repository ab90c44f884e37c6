// SPDX-License-Identifier: Apache-2.0
// Sessions into a map that has content already, without the robot's pose in it.
#include "core/base/status_macros.h"
#include "server/app/mapping/session_mapping.h"
#include "tests/support/pose_matchers.h"
#include "tests/unit/server/app/drawn_drive.h"
#include "tests/unit/server/app/mapping/mapping_fixture.h"

namespace enfilade::server {
namespace {

using localization::DrawnMap;
using ::testing::HasSubstr;
using testing::PoseNear;

class LocatedSessionTest : public MappingFixture {
 protected:
  SessionId Record(const std::string& id, const std::vector<sensor::Record>& log, bool finished = true) {
    const SessionId session = NewSession(id);
    const storage::RecordBatch batch{site_, session, log, {}};
    for (const auto& result : stores_.records.AppendGroup(Soon(), absl::MakeConstSpan(&batch, 1))) EXPECT_OK(result);
    if (finished) Finish(session);
    return session;
  }
  // Maps what is recorded, as a worker does, in two turns of which the first ends after one step.
  absl::Status Map(const SessionId& session) {
    for (int turn = 0; turn < 2; ++turn) {
      ENFILADE_ASSIGN_OR_RETURN(const auto leased,
                                stores_.mappings.Acquire(Soon(), "worker", std::chrono::seconds(10)));
      if (!leased || leased->session.id != session) return absl::InternalError("another session");
      ENFILADE_ASSIGN_OR_RETURN(const auto mapping, SessionMapping::Load(mapping_stores(), {}, leased->session));
      for (auto progress = SessionMapping::Progress::kWorked; progress == SessionMapping::Progress::kWorked;) {
        ENFILADE_ASSIGN_OR_RETURN(progress, mapping->Step(leased->lease));
        if (turn == 0) break;
      }
      ENFILADE_RETURN_IF_ERROR(mapping->Store(leased->lease));
      ENFILADE_RETURN_IF_ERROR(stores_.mappings.Release(Soon(), leased->lease, 0));
    }
    return absl::OkStatus();
  }
  std::vector<slam::SlamNode> Keyframes(const SessionId& session) {
    auto nodes = stores_.mappings.ListKeyframes(Soon(), site_, session);
    EXPECT_OK(nodes);
    return *nodes;
  }

  const DrawnMap room_ = localization::UniqueRoom();
  // Twice through the room; the map's frame begins at the first pose.
  const std::vector<Pose2> first_way_ = {
      {1.5, 2.5, 0.0}, {4.5, 2.8, 0.0}, {7.0, 2.8, 0.5}, {4.5, 2.8, 3.1}, {1.5, 2.5, 3.1}};
  const std::vector<Pose2> elsewhere_ = {{6.3, 3.0, -2.0}, {5.0, 2.8, -2.8}, {3.0, 2.6, 3.1}};
};

TEST_F(LocatedSessionTest, ARobotThatStartsElsewhereIsMappedWhereItIs) {
  ASSERT_OK(Map(Record("first", RecordDrive(room_, first_way_))));
  const SessionId second = Record("second", RecordDrive(room_, elsewhere_));
  ASSERT_OK(Map(second));
  EXPECT_EQ(Session(second).state, storage::SessionState::kMapped);
  const std::vector<slam::SlamNode> keyframes = Keyframes(second);
  ASSERT_GE(keyframes.size(), 5U);
  EXPECT_THAT(keyframes.front().T_map_node, PoseNear(Between(first_way_.front(), elsewhere_.front()), 0.1, 0.04));
  EXPECT_THAT(keyframes.back().T_map_node, PoseNear(Between(first_way_.front(), elsewhere_.back()), 0.35, 0.2));
}

TEST_F(LocatedSessionTest, ARobotThatIsNowhereInTheMapChangesNothing) {
  ASSERT_OK(Map(Record("first", RecordDrive(room_, first_way_))));
  const std::int64_t revision = stores_.revisions.Get(Soon(), site_, hall_, 0)->number;
  const SessionId second = Record("second", RecordDrive(localization::SymmetricRoom(), {{2.0, 1.2, 0}, {4.0, 1.2, 0}}));
  const absl::Status status = Map(second);
  EXPECT_TRUE(absl::IsFailedPrecondition(status));
  EXPECT_THAT(std::string(status.message()), HasSubstr("not located"));
  EXPECT_EQ(stores_.revisions.Get(Soon(), site_, hall_, 0)->number, revision);
  EXPECT_TRUE(Keyframes(second).empty());
}

TEST_F(LocatedSessionTest, ALiveSessionWaitsForScansThatLocateIt) {
  ASSERT_OK(Map(Record("first", RecordDrive(room_, first_way_))));
  std::vector<sensor::Record> log = RecordDrive(room_, elsewhere_);
  const std::vector<sensor::Record> rest(log.begin() + 1, log.end());
  log.resize(1);  // odometry only
  const SessionId second = Record("second", log, /*finished=*/false);
  ASSERT_OK(Map(second));
  EXPECT_EQ(Session(second).mapped_sequence, 0);
  const storage::RecordBatch batch{site_, second, rest, {}};
  for (const auto& result : stores_.records.AppendGroup(Soon(), absl::MakeConstSpan(&batch, 1))) ASSERT_OK(result);
  ASSERT_OK(Map(second));
  EXPECT_GT(Session(second).mapped_sequence, 0);
  EXPECT_THAT(Keyframes(second).front().T_map_node,
              PoseNear(Between(first_way_.front(), elsewhere_.front()), 0.1, 0.04));
}

TEST_F(LocatedSessionTest, ASessionWithoutScansIsMapped) {
  ASSERT_OK(Map(Record("first", RecordDrive(room_, first_way_))));
  const SessionId second = Record("second", {{1, sensor::Odometry{kNsPerSecond, {}}}});
  ASSERT_OK(Map(second));
  EXPECT_EQ(Session(second).state, storage::SessionState::kMapped);
}

}  // namespace
}  // namespace enfilade::server
