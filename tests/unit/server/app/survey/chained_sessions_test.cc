// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/chained_sessions.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "server/app/mapping/session_mapping.h"
#include "tests/unit/core/slam/synthetic_drive.h"
#include "tests/unit/server/app/rearrange/rearranged_campus.h"

namespace enfilade::server {
namespace {

using testing::PoseNear;

// A drive around a block, in sessions that are mapped as the server does it.
class ChainedSessionsTest : public RearrangedCampus {
 protected:
  static std::vector<Pose2> Poses() { return testing::Drive({{3, 3}, {15, 3}, {15, 7}, {3, 7}, {3, 3}, {15, 3}}, 0.4); }
  static std::vector<sensor::PairedScan> Scans() {
    const auto walls =
        testing::WallsFromText({"##########", "#........#", "#...##...#", "#........#", "##########"}, 2.0);
    return testing::Record(walls, Poses(), {}, {0.03, 0.03}, 1);
  }

  // Records scans `begin` to `end` with odometry, and maps them into a map of their own.
  SessionId Map(const std::string& id, std::size_t begin, std::size_t end) {
    AddMap("map-" + id);
    return MapInto("map-" + id, id, begin, end);
  }
  SessionId MapInto(const std::string& map, const std::string& id, std::size_t begin, std::size_t end,
                    const std::optional<Pose2>& T_map_entry = std::nullopt) {
    storage::Session session = MakeSession(site_, id, map);
    if (T_map_entry) session.entry.T_map_robot = PoseWithCovariance{*T_map_entry, Eigen::Matrix3d::Identity() * 1e-4};
    EXPECT_OK(stores_.sessions.Create(Soon(), session, ""));
    std::vector<sensor::Record> records;
    for (std::size_t i = begin; i < end; ++i) {
      const auto sequence = static_cast<std::int64_t>(records.size()) + 1;
      if (odometry_) records.push_back({sequence, sensor::Odometry{scans_[i].scan.time, *scans_[i].T_odom_robot}});
      records.push_back({static_cast<std::int64_t>(records.size()) + 1, scans_[i].scan});
    }
    EXPECT_OK(stores_.records.Append(Soon(), {site_, session.id, records, {}}));
    EXPECT_OK(stores_.sessions.Finish(Soon(), site_, session.id, static_cast<std::int64_t>(records.size())));
    const auto leased = stores_.mappings.Acquire(Soon(), "worker", std::chrono::seconds(60));
    EXPECT_OK(leased);
    const SessionMappingStores stores{stores_.mappings,  stores_.records,     stores_.sessions, stores_.blobs,
                                      stores_.revisions, stores_.robot_poses, stores_.maps};
    const auto mapping = SessionMapping::Load(stores, mapping_, (*leased)->session);
    EXPECT_OK(mapping);
    auto progress = SessionMapping::Progress::kWorked;
    while (progress == SessionMapping::Progress::kWorked) progress = *(*mapping)->Step((*leased)->lease);
    EXPECT_EQ(progress, SessionMapping::Progress::kEnded);
    EXPECT_OK(stores_.mappings.Release(Soon(), (*leased)->lease, 0));
    return session.id;
  }

  struct Chained {
    slam::ChainedMap map;
    std::vector<std::size_t> appended;  // after each call
  };
  Chained ChainOf(const std::vector<SessionId>& ids, std::optional<TimeNs> until = std::nullopt) {
    std::vector<storage::Session> sessions;
    for (const SessionId& id : ids) sessions.push_back(*stores_.sessions.Get(Soon(), site_, id));
    std::vector<const storage::Session*> drive;
    for (const storage::Session& session : sessions) drive.push_back(&session);
    ChainedSessions chained(reader_, mapping_.pairing, slam_, drive, until);
    slam::SessionChain chain(slam_, std::nullopt);
    Chained result;
    while (!chained.done()) {
      EXPECT_OK(chained.AppendNext(chain));
      result.appended.push_back(chained.appended());
    }
    result.map = chain.Finish();
    return result;
  }

  // Relative to the first one, as the truth.
  void ExpectDriven(const slam::ChainedMap& map, std::size_t scans) {
    const std::vector<Pose2> poses = Poses();
    ASSERT_EQ(map.trajectory.size(), scans);
    for (std::size_t i = 0; i < scans; ++i) {
      EXPECT_EQ(map.trajectory[i].time, scans_[i].scan.time);
      EXPECT_THAT(map.trajectory[i].T_map_robot, PoseNear(Between(poses.front(), poses[i]), 0.1, 0.03)) << i;
    }
  }

  const std::vector<sensor::PairedScan> scans_ = Scans();
  bool odometry_ = true;
  SessionMappingOptions mapping_;
  slam::SlamOptions slam_;
  absl::Status go_on_;
  const std::function<absl::Status()> proceed_ = [this] { return go_on_; };
  const SessionReader reader_{stores_.records, stores_.mappings, site_, proceed_};
};

TEST_F(ChainedSessionsTest, AppendsTheSessionsOfADrive) {
  const Chained chained = ChainOf({Map("a", 0, 40), Map("b", 40, 100), Map("c", 100, scans_.size())});
  EXPECT_THAT(chained.appended, ::testing::ElementsAre(1, 2, 3));
  ExpectDriven(chained.map, scans_.size());
}

TEST_F(ChainedSessionsTest, ThePiecesOfACutSessionAreOneAgain) {
  const SessionId first = Map("a", 0, 40);
  const SessionId second = Map("b", 40, scans_.size());
  const slam::ChainedMap before = ChainOf({first, second}).map;
  const SessionId rest("rest");
  const SessionId end("end");
  ASSERT_OK(Split("map-b", {}, "annex", {{second, 101, rest}}));
  ASSERT_OK(Split("annex", {}, "yard", {{rest, 161, end}}));
  // Into another frame each.
  AddMap("far");
  ASSERT_OK(Merge("far", "annex", Pose2{30.0, -5.0, 1.2}));
  ASSERT_OK(Merge("map-a", "yard", Pose2{-7.0, 40.0, 3.0}));
  const Chained chained = ChainOf({first, second, rest, end});
  EXPECT_THAT(chained.appended, ::testing::ElementsAre(1, 4));
  EXPECT_EQ(chained.map.trajectory.size(), before.trajectory.size());
  // Loop closures across a cut are looked for once more.
  for (std::size_t i = 0; i < scans_.size(); ++i) {
    EXPECT_THAT(chained.map.trajectory[i].T_map_robot, PoseNear(before.trajectory[i].T_map_robot, 0.02, 0.005)) << i;
  }
}

TEST_F(ChainedSessionsTest, ARestAloneIsASession) {
  const SessionId session = Map("a", 0, scans_.size());
  ASSERT_OK(Split("map-a", {}, "annex", {{session, 101, SessionId("rest")}}));
  const slam::ChainedMap whole = ChainOf({session, SessionId("rest")}).map;
  const slam::ChainedMap rest = ChainOf({SessionId("rest")}).map;
  ASSERT_GT(rest.trajectory.size(), 80U);
  const auto& same = whole.trajectory[scans_.size() - rest.trajectory.size()];
  EXPECT_EQ(same.time, rest.trajectory.front().time);
  EXPECT_THAT(Between(rest.trajectory.front().T_map_robot, rest.trajectory.back().T_map_robot),
              PoseNear(Between(same.T_map_robot, whole.trajectory.back().T_map_robot), 0.05, 0.02));
}

TEST_F(ChainedSessionsTest, LeavesOutWhatIsLater) {
  const Chained chained = ChainOf({Map("a", 0, 100), Map("b", 100, scans_.size())}, scans_[119].scan.time);
  EXPECT_EQ(chained.map.trajectory.back().time, scans_[119].scan.time);
  EXPECT_THAT(chained.map.trajectory.back().T_map_robot,
              PoseNear(ChainOf({SessionId("a"), SessionId("b")}).map.trajectory[119].T_map_robot, 0.05, 0.02));
}

TEST_F(ChainedSessionsTest, MapsASessionAgainThatHasAnotherResolution) {
  slam::SlamOptions coarse;
  coarse.resolution = 0.1;
  const SessionId first = Map("a", 0, 60);
  mapping_.slam = slam::SlamProfiles(coarse);
  const SessionId second = Map("b", 60, scans_.size());
  const slam::ChainedMap map = ChainOf({first, second}).map;
  EXPECT_EQ(map.grid.geometry.resolution, slam_.resolution);
  EXPECT_EQ(map.trajectory.back().time, scans_.back().scan.time);
  EXPECT_LT(map.trajectory.size(), scans_.size()) << "by its keyframes";
  const std::vector<Pose2> poses = Poses();
  EXPECT_THAT(map.trajectory.back().T_map_robot, PoseNear(Between(poses.front(), poses[scans_.size() - 1]), 0.1, 0.03));
}

TEST_F(ChainedSessionsTest, MapsASessionWithoutOdometryAgainByAllItsScans) {
  odometry_ = false;
  slam::SlamOptions coarse;
  coarse.resolution = 0.1;
  mapping_.slam = slam::SlamProfiles(coarse);
  ExpectDriven(ChainOf({Map("a", 0, 60), Map("b", 60, scans_.size())}).map, scans_.size());
}

TEST_F(ChainedSessionsTest, LeavesOutTheMapThatASessionHasContinued) {
  const SessionId first = Map("a", 0, 80);
  const auto keyframes = stores_.mappings.ListKeyframes(Soon(), site_, first);
  ASSERT_OK(keyframes);
  const SessionId second = MapInto("map-a", "b", 80, scans_.size(), keyframes->back().T_map_node);
  ASSERT_TRUE(stores_.mappings.Load(Soon(), site_, second).value()->map.submaps.contains(0));
  const Chained both = ChainOf({first, second});
  ExpectDriven(both.map, scans_.size());
  EXPECT_EQ(ChainOf({second}).map.trajectory.size(), scans_.size() - 80);
}

TEST_F(ChainedSessionsTest, ASessionThatIsNotMappedAddsNothing) {
  const SessionId first = Map("a", 0, 60);
  const SessionId second = Map("c", 60, scans_.size());
  Record("b", "map-a");
  const Chained chained = ChainOf({first, SessionId("b"), second});
  EXPECT_THAT(chained.appended, ::testing::ElementsAre(1, 2, 3));
  ExpectDriven(chained.map, scans_.size());
}

TEST_F(ChainedSessionsTest, AfterAnErrorTheChainIsAsBefore) {
  const std::vector<SessionId> ids{Map("a", 0, 60), Map("b", 60, scans_.size())};
  std::vector<storage::Session> sessions;
  for (const SessionId& id : ids) sessions.push_back(*stores_.sessions.Get(Soon(), site_, id));
  const std::vector<const storage::Session*> drive{&sessions[0], &sessions[1]};
  ChainedSessions chained(reader_, mapping_.pairing, slam_, drive, std::nullopt);
  slam::SessionChain chain(slam_, std::nullopt);
  ASSERT_OK(chained.AppendNext(chain));
  go_on_ = absl::CancelledError("stop");
  EXPECT_CODE(chained.AppendNext(chain), absl::StatusCode::kCancelled);
  EXPECT_EQ(chained.appended(), 1U);
  ChainedSessions again(reader_, mapping_.pairing, slam_, std::span(drive).subspan(1), std::nullopt);
  go_on_ = absl::OkStatus();
  ASSERT_OK(again.AppendNext(chain));
  EXPECT_EQ(chain.Finish().grid, ChainOf(ids).map.grid);
}

}  // namespace
}  // namespace enfilade::server
