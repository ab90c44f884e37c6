// SPDX-License-Identifier: Apache-2.0
#include "server/app/mapping/session_mapping.h"

#include <algorithm>
#include <functional>
#include <random>

#include "server/app/mapping/raster_revision.h"
#include "tests/unit/server/app/forwarding_revision_store.h"
#include "tests/unit/server/app/mapping/session_mapping_fixture.h"

namespace enfilade::server {
namespace {

using ::testing::HasSubstr;

class SessionMappingTest : public SessionMappingFixture {
 protected:
  absl::StatusOr<storage::MapRevision> CurrentRevision() { return stores_.revisions.Get(Soon(), site_, hall_, 0); }
  grid::OccupancyGrid CurrentGrid() {
    const auto revision = CurrentRevision();
    EXPECT_OK(revision);
    const auto raster = ReadRaster(Soon(), stores_.revisions, *revision);
    EXPECT_OK(raster);
    return *OnMapLattice(*raster, revision->geometry.resolution);
  }
};

TEST_F(SessionMappingTest, MapsAFinishedSessionLikeTheOfflineTool) {
  const SessionId session = NewFinishedSession("s");
  const storage::LeasedSession leased = Acquire();
  const auto mapping = Load(leased);
  EXPECT_EQ(MapOn(*mapping, leased.lease), Progress::kEnded);
  EXPECT_TRUE(mapping->ended());
  ExpectOfflineMap(session);
  EXPECT_EQ(Session(session).state, storage::SessionState::kMapped);
  EXPECT_EQ(Session(session).mapping_counts.used, static_cast<std::int64_t>(OfflineMap().trajectory.size()));
  EXPECT_EQ(Session(session).mapping_counts.keyframes, static_cast<std::int64_t>(OfflineMap().nodes.size()));
  ASSERT_OK(CurrentRevision());
  EXPECT_EQ(CurrentRevision()->session, session);
}

TEST_F(SessionMappingTest, WaitsForMoreRecordsWhileTheSessionIsRecorded) {
  const SessionId session = NewSession("s");
  Append(session, 0, 100);
  const storage::LeasedSession leased = Acquire();
  const auto mapping = Load(leased);
  EXPECT_EQ(MapOn(*mapping, leased.lease), Progress::kWaiting);
  EXPECT_EQ(MapOn(*mapping, leased.lease), Progress::kWaiting);
  EXPECT_FALSE(mapping->ended());
  Append(session, 100, Log().size());
  EXPECT_EQ(MapOn(*mapping, leased.lease), Progress::kWaiting);
  Finish(session);
  EXPECT_EQ(MapOn(*mapping, leased.lease), Progress::kEnded);
  ExpectOfflineMap(session);
}

// The result must not depend on where mapping was interrupted, nor by whom it was resumed.
TEST_F(SessionMappingTest, ResumingFromCheckpointsGivesTheSameResult) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const std::string map = "room" + std::to_string(seed);
    ASSERT_OK(stores_.maps.Create(Soon(), MakeMap(site_, map), ""));
    const SessionId session = NewSession("s" + std::to_string(seed), map);
    std::minstd_rand random(seed);
    for (std::size_t begin = 0; begin < Log().size();) {
      const std::size_t end = std::min<std::size_t>(Log().size(), begin + 1 + random() % 80);
      Append(session, begin, end);
      begin = end;
      const storage::LeasedSession leased = Acquire();
      const auto mapping = Load(leased);
      EXPECT_EQ(MapOn(*mapping, leased.lease), Progress::kWaiting);
      EXPECT_OK(mapping->Store(leased.lease));
      EXPECT_OK(stores_.mappings.Release(Soon(), leased.lease, 0));
    }
    Finish(session);
    MapAll(session);
    ExpectOfflineMap(session);
  }
}

// What a killed worker had mapped and not stored is mapped again.
TEST_F(SessionMappingTest, WorkThatWasNotStoredIsRepeated) {
  const SessionId session = NewSession("s");
  Append(session, 0, 100);
  {
    const storage::LeasedSession leased = Acquire();
    const auto mapping = Load(leased);
    MapOn(*mapping, leased.lease);
    EXPECT_OK(mapping->Store(leased.lease));
    Append(session, 100, 200);
    MapOn(*mapping, leased.lease);
    EXPECT_EQ(mapping->stored_sequence(), 100);
    EXPECT_OK(stores_.mappings.Release(Soon(), leased.lease, 0));
  }
  Append(session, 200, Log().size());
  Finish(session);
  MapAll(session);
  ExpectOfflineMap(session);
}

TEST_F(SessionMappingTest, CommitsWhenACheckpointIsDue) {
  const SessionId session = NewSession("s");
  Append(session, 0, 100);
  options_.checkpoint_interval = std::chrono::duration<double>(0);
  options_.revision_interval = std::chrono::hours(1);
  const storage::LeasedSession leased = Acquire();
  const auto mapping = Load(leased);
  EXPECT_EQ(MapOn(*mapping, leased.lease), Progress::kWaiting);
  EXPECT_EQ(mapping->stored_sequence(), 100);
  EXPECT_EQ(Session(session).mapped_sequence, 100);
  EXPECT_CODE(CurrentRevision(), absl::StatusCode::kNotFound) << "no revision is due";
}

TEST_F(SessionMappingTest, PublishesARevisionWhenOneIsDue) {
  const SessionId session = NewSession("s");
  Append(session, 0, 100);
  options_.revision_interval = std::chrono::duration<double>(0);
  const storage::LeasedSession leased = Acquire();
  const auto mapping = Load(leased);
  MapOn(*mapping, leased.lease);
  EXPECT_EQ(stores_.database.CountRevisions(), 0) << "no checkpoint was due";
  ASSERT_OK(mapping->Store(leased.lease));
  EXPECT_EQ(stores_.database.CountRevisions(), 1);
  ASSERT_OK(mapping->Store(leased.lease));
  EXPECT_EQ(stores_.database.CountRevisions(), 1) << "nothing new to store";
  EXPECT_EQ(stores_.maps.Get(Soon(), site_, hall_)->state, storage::MapState::kMapping);
}

TEST_F(SessionMappingTest, AFinishedSessionWithoutRecordsEndsWithoutARevision) {
  const SessionId session = NewSession("s");
  Finish(session);
  MapAll(session);
  EXPECT_EQ(Session(session).state, storage::SessionState::kMapped);
  EXPECT_CODE(CurrentRevision(), absl::StatusCode::kNotFound);
}

TEST_F(SessionMappingTest, AWorkerThatLostItsLeaseStoresNothing) {
  const SessionId session = NewSession("s");
  Append(session, 0, 100);
  const storage::LeasedSession lost = Acquire();
  const auto late = Load(lost);
  MapOn(*late, lost.lease);
  stores_.database.AdvanceClock(kSessionLeaseTime + std::chrono::seconds(1));
  const storage::LeasedSession taken = Acquire();
  const auto mapping = Load(taken);
  EXPECT_CODE(late->Store(lost.lease), absl::StatusCode::kAborted);
  EXPECT_EQ(Session(session).mapped_sequence, 0);
  Append(session, 100, Log().size());
  Finish(session);
  EXPECT_EQ(MapOn(*mapping, taken.lease), Progress::kEnded);
  auto progress = late->Step(lost.lease);
  while (progress.ok() && *progress == Progress::kWorked) progress = late->Step(lost.lease);
  EXPECT_CODE(progress, absl::StatusCode::kAborted) << "at the end of the log it would commit";
  ExpectOfflineMap(session);
}

TEST_F(SessionMappingTest, AnUnreadableRecordIsDataLoss) {
  const SessionId session = NewSession("s");
  Append(session, 0, 100);
  stores_.database.CorruptRecord(site_, session, 50);
  const storage::LeasedSession leased = Acquire();
  EXPECT_CODE(Load(leased)->Step(leased.lease), absl::StatusCode::kDataLoss);
}

TEST_F(SessionMappingTest, RecordsThatWereDeletedBeforeTheyWereMappedAreAnError) {
  const SessionId session = NewSession("s");
  Append(session, 0, 100);
  {
    const storage::LeasedSession leased = Acquire();
    const auto mapping = Load(leased);
    MapOn(*mapping, leased.lease);
    ASSERT_OK(mapping->Store(leased.lease));
    ASSERT_OK(stores_.mappings.Release(Soon(), leased.lease, 0));
  }
  Append(session, 100, 150);
  Finish(session);
  stores_.database.ExpireRecords(site_, session);
  const storage::LeasedSession leased = Acquire();
  EXPECT_STATUS(Load(leased)->Step(leased.lease), absl::StatusCode::kFailedPrecondition,
                HasSubstr("from sequence 101 on"));
}

TEST_F(SessionMappingTest, FailingASessionKeepsItsResults) {
  const SessionId session = NewSession("s");
  Append(session, 0, 150);
  const storage::LeasedSession leased = Acquire();
  const auto mapping = Load(leased);
  MapOn(*mapping, leased.lease);
  ASSERT_OK(mapping->Store(leased.lease));
  const std::size_t poses = StoredMap(session).trajectory.size();
  Finish(session);
  const storage::LeasedSession present{leased.lease, Session(session)};
  ASSERT_OK(SessionMapping::Fail(mapping_stores(), present, absl::DataLossError("record 151 is broken")));
  EXPECT_EQ(Session(session).state, storage::SessionState::kFailed);
  EXPECT_EQ(Session(session).error, "record 151 is broken");
  EXPECT_EQ(Session(session).mapped_sequence, 150);
  EXPECT_EQ(Session(session).mapping_counts.used, static_cast<std::int64_t>(poses));
  EXPECT_EQ(StoredMap(session).trajectory.size(), poses);
  EXPECT_GT(poses, 0U);
}

TEST_F(SessionMappingTest, AMapIsMappedWithItsProfileOrThatOfItsEnvironment) {
  slam::SlamOptions indoor;
  indoor.resolution = 0.05;
  slam::SlamOptions outdoor;
  outdoor.resolution = 0.1;
  slam::SlamOptions coarse;
  coarse.resolution = 0.2;
  options_.slam = slam::SlamProfiles(indoor);
  options_.slam.Set(slam::SlamProfiles::kOutdoor, outdoor);
  options_.slam.Set("coarse", coarse);
  struct Case {
    const char* profile;
    Environment environment;
    double resolution;
  };
  const Case cases[] = {{"", Environment::kIndoor, 0.05},
                        {"", Environment::kOutdoor, 0.1},
                        {"coarse", Environment::kOutdoor, 0.2},
                        {"unknown", Environment::kOutdoor, 0.1}};
  int number = 0;
  for (const Case& one : cases) {
    const std::string id = "map" + std::to_string(number++);
    storage::Map map = MakeMap(site_, id);
    map.slam_profile = one.profile;
    map.environment = one.environment;
    ASSERT_OK(stores_.maps.Create(Soon(), map, ""));
    const SessionId session = NewSession("in-" + id, id);
    Append(session, 0, 60);
    Finish(session);
    MapAll(session);
    const auto revision = stores_.revisions.Get(Soon(), site_, MapId(id), 0);
    ASSERT_OK(revision);
    EXPECT_EQ(revision->geometry.resolution, one.resolution) << one.profile;
  }
}

TEST_F(SessionMappingTest, StoresTheRobotsPoseWithEachCommit) {
  const SessionId session = NewSession("s");
  Append(session, 0, 100);
  const storage::LeasedSession leased = Acquire();
  const auto mapping = Load(leased);
  MapOn(*mapping, leased.lease);
  EXPECT_CODE(stores_.robot_poses.Get(Soon(), site_, RobotId("r")), absl::StatusCode::kNotFound);
  ASSERT_OK(mapping->Store(leased.lease));
  ASSERT_OK_AND_ASSIGN(const storage::RobotPose pose, stores_.robot_poses.Get(Soon(), site_, RobotId("r")));
  const std::vector<slam::StampedPose> trajectory = slam::TrajectoryOf(StoredMap(session));
  EXPECT_EQ(pose.map, hall_);
  EXPECT_EQ(pose.session, session);
  EXPECT_GE(pose.time, trajectory.back().time);
  EXPECT_LT((pose.T_map_robot.pose.translation() - trajectory.back().T_map_robot.translation()).norm(), 0.5);
}

TEST_F(SessionMappingTest, ASessionWithAnEntryPoseContinuesInTheExistingMap) {
  MapAll(NewFinishedSession("first"));
  const grid::OccupancyGrid before = CurrentGrid();
  storage::Session entering = MakeSession(site_, "second", "hall");
  // The same drive again, entered where it began: the first keyframe is the origin of the map.
  entering.entry.T_map_robot = PoseWithCovariance{{}, Eigen::Vector3d(0.01, 0.01, 0.001).asDiagonal()};
  ASSERT_OK(stores_.sessions.Create(Soon(), entering, ""));
  Append(entering.id, 0, Log().size());
  Finish(entering.id);
  MapAll(entering.id);
  const std::vector<slam::StampedPose> first = slam::TrajectoryOf(StoredMap(SessionId("first")));
  const std::vector<slam::StampedPose> second = slam::TrajectoryOf(StoredMap(entering.id));
  ASSERT_FALSE(second.empty());
  for (const slam::StampedPose& pose : second) {
    const auto same =
        std::find_if(first.begin(), first.end(), [&](const auto& other) { return other.time == pose.time; });
    ASSERT_NE(same, first.end());
    EXPECT_LT((same->T_map_robot.translation() - pose.T_map_robot.translation()).norm(), 0.15);
  }
  EXPECT_EQ(CurrentRevision()->session, entering.id);
  EXPECT_GE(CurrentGrid().cells.size(), before.cells.size()) << "both layers are in the revision";
}

// Another session commits its layer between the reading of the layers and the commit.
class RacingRevisionStore final : public ForwardingRevisionStore {
 public:
  RacingRevisionStore(const storage::RevisionStore& store, std::function<void()> after_layers)
      : ForwardingRevisionStore(store), after_layers_(std::move(after_layers)) {}

  absl::StatusOr<storage::LayersBeside> ReadRunsBeside(const storage::CallContext& context, const SiteId& site,
                                                       const MapId& map, const SessionId& session,
                                                       double resolution) const override {
    auto layers = ForwardingRevisionStore::ReadRunsBeside(context, site, map, session, resolution);
    if (reads_++ == 0) after_layers_();
    return layers;
  }
  int reads() const { return reads_; }

 private:
  const std::function<void()> after_layers_;
  mutable int reads_ = 0;
};

TEST_F(SessionMappingTest, ComposesARevisionAgainIfAnotherSessionChangedItsLayer) {
  // Both sessions are of the same place, so that the revision of both is at least that of one.
  const SessionId slow = NewSession("slow");
  Append(slow, 0, 60);
  const storage::LeasedSession leased = Acquire();
  const SessionId fast = NewFinishedSession("fast");
  RacingRevisionStore racing(stores_.revisions, [&] { MapAll(fast); });
  SessionMappingStores stores{stores_.mappings, stores_.records,     stores_.sessions, stores_.blobs,
                              racing,           stores_.robot_poses, stores_.maps};
  auto mapping = SessionMapping::Load(stores, options_, leased.session);
  ASSERT_OK(mapping);
  Finish(slow);
  EXPECT_EQ(MapOn(**mapping, leased.lease), Progress::kEnded);
  EXPECT_EQ(racing.reads(), 2);
  EXPECT_EQ(CurrentRevision()->session, slow);
  ASSERT_OK_AND_ASSIGN(const storage::MapRevision fast_revision, stores_.revisions.Get(Soon(), site_, hall_, 1));
  EXPECT_EQ(fast_revision.session, fast);
  EXPECT_GE(CurrentRevision()->geometry.width, fast_revision.geometry.width) << "the other layer is not lost";
}

}  // namespace
}  // namespace enfilade::server
