// SPDX-License-Identifier: Apache-2.0
#include "server/app/mapping/session_entry.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/support/pose_matchers.h"
#include "tests/unit/server/app/mapping/session_mapping_fixture.h"

namespace enfilade::server {
namespace {

using testing::PoseNear;

// The robot goes through a door: its next session is in another map. Its wheels slip in between.
class NextSessionTest : public SessionMappingFixture {
 protected:
  static constexpr std::size_t kScans = 40;  // of the first session; each is a sample of odometry and a scan
  static constexpr Pose2 kEntry{5.0, -3.0, 2.0};

  NextSessionTest() {
    EXPECT_OK(stores_.maps.Create(Soon(), MakeMap(site_, "room"), ""));
    NewSession("s");
    Append(SessionId("s"), 0, 2 * kScans);
    Finish(SessionId("s"));
    MapAll(SessionId("s"));
    storage::Session next = MakeSession(site_, "next", "room");
    next.entry.previous = SessionId("s");
    next.entry.T_map_robot = {kEntry, 1e-4 * Eigen::Matrix3d::Identity()};
    next.entry.T_odom_robot = OdometryOf(kScans - 1);
    EXPECT_OK(stores_.sessions.Create(Soon(), next, ""));
    for (std::size_t i = 2 * kScans; i < Log().size(); ++i) {
      sensor::Record record = Log()[i];
      record.sequence -= static_cast<std::int64_t>(2 * kScans);
      if (auto* odometry = std::get_if<sensor::Odometry>(&record.payload)) {
        odometry->T_odom_robot =
            OdometryOf(kScans - 1) * kSlip * Between(OdometryOf(kScans - 1), odometry->T_odom_robot);
      }
      log_.push_back(record);
    }
  }

  static Pose2 OdometryOf(std::size_t scan) { return std::get<sensor::Odometry>(Log()[2 * scan].payload).T_odom_robot; }
  static Pose2 FirstPose() { return kEntry * Between(Truth()[kScans - 1], Truth()[kScans]); }

  void AppendNext(std::size_t begin, std::size_t end) {
    const std::vector<sensor::Record> records(log_.begin() + static_cast<std::ptrdiff_t>(begin),
                                              log_.begin() + static_cast<std::ptrdiff_t>(end));
    const SessionId next("next");
    const storage::RecordBatch batch{site_, next, records, {}};
    for (const auto& result : stores_.records.AppendGroup(Soon(), absl::MakeConstSpan(&batch, 1))) EXPECT_OK(result);
  }

  static constexpr Pose2 kSlip{0.05, -0.05, 0.04};
  std::vector<sensor::Record> log_;
};

TEST_F(NextSessionTest, BeginsWhereItsFirstScanFitsTheLastOneOfTheSessionBefore) {
  AppendNext(0, log_.size());
  Finish(SessionId("next"));
  MapAll(SessionId("next"));
  EXPECT_THAT(slam::TrajectoryOf(StoredMap(SessionId("next"))).front().T_map_robot, PoseNear(FirstPose(), 0.02, 0.01));
}

// A server that ends after the first odometry knows the scan nevertheless.
TEST_F(NextSessionTest, BeginsThereAfterARestartBeforeItsFirstScan) {
  AppendNext(0, 1);
  {
    const storage::LeasedSession leased = Acquire();
    const auto mapping = Load(leased);
    EXPECT_EQ(MapOn(*mapping, leased.lease), Progress::kWaiting);
    EXPECT_OK(mapping->Store(leased.lease));
    EXPECT_OK(stores_.mappings.Release(Soon(), leased.lease, 0));
  }
  AppendNext(1, log_.size());
  Finish(SessionId("next"));
  MapAll(SessionId("next"));
  EXPECT_THAT(slam::TrajectoryOf(StoredMap(SessionId("next"))).front().T_map_robot, PoseNear(FirstPose(), 0.02, 0.01));
}

// Retention may have deleted the records before: then odometry alone shows where the session begins.
TEST_F(NextSessionTest, BeginsByOdometryWithoutAScanNearTheEntry) {
  storage::Session session = Session(SessionId("next"));
  session.entry.T_odom_robot = OdometryOf(kScans - 1) * Pose2{0.5, 0.0, 0.0};
  AppendNext(0, log_.size());
  const auto entry = ReadEntry(stores_.sessions, stores_.records, {}, {}, session);
  ASSERT_OK(entry);
  EXPECT_FALSE(entry->seen);
  EXPECT_EQ(entry->T_map_robot.pose, kEntry);
}

}  // namespace
}  // namespace enfilade::server
