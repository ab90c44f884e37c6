// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/simulation.h"
#include "core/slam/mapper/log_mapper.h"
#include "proto/convert/record.h"
#include "tests/rpc/server_test.h"

namespace enfilade::testing {
namespace {

class MappingTest : public ServerTest {
 protected:
  static std::vector<sensor::Record> SimulatedLog(int laps = 1) {
    simulator::SimulationOptions options = simulator::RoomsOptions();
    options.laps = laps;
    const auto drive = simulator::SimulateRooms(options);
    EXPECT_OK(drive);
    std::vector<sensor::Record> log;
    for (const simulator::SimulatedRecord& entry : drive->records) {
      sensor::Record record;
      record.sequence = static_cast<std::int64_t>(log.size()) + 1;
      std::visit([&](const auto& payload) { record.payload = payload; }, entry.payload);
      log.push_back(std::move(record));
    }
    return log;
  }

  void Stream(const std::string& session, const std::vector<sensor::Record>& log, std::size_t begin, std::size_t end) {
    TestStream stream(*connection_, session);
    std::vector<v1::Record> batch;
    for (std::size_t i = begin; i < end; ++i) {
      batch.push_back(convert::ToProto(log[i]));
      if (batch.size() < 200 && i + 1 < end) continue;
      ASSERT_TRUE(stream.SendBatch(batch));
      batch.clear();
    }
    ASSERT_TRUE(stream.AwaitAcknowledged(log[end - 1].sequence));
  }

  std::vector<v1::TrajectoryPose> Trajectory(const std::string& session) {
    const auto stub = v1::SessionService::NewStub(connection_->channel());
    grpc::ClientContext context;
    v1::ExportTrajectoryRequest request;
    request.set_name(session);
    const auto reader = stub->ExportTrajectory(&context, request);
    v1::ExportTrajectoryResponse part;
    std::vector<v1::TrajectoryPose> poses;
    while (reader->Read(&part)) poses.insert(poses.end(), part.poses().begin(), part.poses().end());
    EXPECT_TRUE(reader->Finish().ok());
    return poses;
  }
};

TEST_F(MappingTest, TheServersMapIsTheOfflineToolsAlsoAcrossRestarts) {
  const std::vector<sensor::Record> log = SimulatedLog();
  slam::LogMapper offline({}, slam::SlamOptions());
  slam::SlamMap expected;
  for (const sensor::Record& record : log) offline.Add(record);
  offline.Finish();
  expected.Apply(offline.TakeDelta());
  const std::vector<slam::StampedPose> expected_poses = slam::TrajectoryOf(expected);

  const std::string session = CreateSession(true);
  Stream(session, log, 0, log.size() / 3);
  Restart(Options());
  Stream(session, log, log.size() / 3, 2 * log.size() / 3);
  Restart(Options());
  Stream(session, log, 2 * log.size() / 3, log.size());
  ASSERT_OK(FinishSession(session, static_cast<std::int64_t>(log.size())));
  AwaitState(session, v1::Session::STATE_MAPPED);

  const auto poses = Trajectory(session);
  ASSERT_EQ(poses.size(), expected_poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(*convert::FromTimestamp(poses[i].time()), expected_poses[i].time);
    EXPECT_EQ(convert::FromProto(poses[i].pose_map_robot()), expected_poses[i].T_map_robot) << i;
  }
  const v1::Session mapped = GetSession(session);
  EXPECT_EQ(mapped.mapped_sequence(), static_cast<std::int64_t>(log.size()));
  EXPECT_EQ(mapped.mapping_counts().used(), static_cast<std::int64_t>(poses.size()));

  v1::GetMapRequest request;
  request.set_name("sites/s/maps/m");
  ASSERT_OK_AND_ASSIGN(const v1::GetMapResponse map, Call(&v1::MapService::Stub::GetMap, request));
  v1::GetMapRevisionRequest get;
  get.set_name(map.map().latest_revision());
  ASSERT_OK_AND_ASSIGN(const auto revision, Call(&v1::MapService::Stub::GetMapRevision, get));
  const grid::OccupancyGrid grid = offline.RenderGrid();
  EXPECT_EQ(revision.revision().width(), grid.geometry.width);
  EXPECT_EQ(revision.revision().height(), grid.geometry.height);
  EXPECT_EQ(revision.revision().session(), session);
}

TEST_F(MappingTest, AnEmptySessionEndsMappedWithoutARevision) {
  const std::string session = CreateSession(true);
  ASSERT_OK(FinishSession(session, 0));
  AwaitState(session, v1::Session::STATE_MAPPED);
  EXPECT_TRUE(Trajectory(session).empty());
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM map_revisions"), "0");
}

TEST_F(MappingTest, SeveralSessionsAreMappedByOneWorkerInTurns) {
  const std::vector<sensor::Record> log = SimulatedLog();
  std::vector<std::string> sessions;
  for (int i = 0; i < 3; ++i) {
    sessions.push_back(CreateSession(true));
    Stream(sessions.back(), log, 0, 400);
    ASSERT_OK(FinishSession(sessions.back(), 400));
  }
  for (const std::string& session : sessions) AwaitState(session, v1::Session::STATE_MAPPED);
  EXPECT_EQ(Trajectory(sessions[0]).size(), Trajectory(sessions[2]).size());
}

TEST_F(MappingTest, ASuspendedClosureLeavesTheMapAndAResumedOneComesBack) {
  const std::vector<sensor::Record> log = SimulatedLog(2);
  const std::string session = CreateSession(true);
  Stream(session, log, 0, log.size());
  ASSERT_OK(FinishSession(session, static_cast<std::int64_t>(log.size())));
  AwaitState(session, v1::Session::STATE_MAPPED);
  const std::string revisions = database_.SqlValue("SELECT count(*) FROM map_revisions");

  v1::ListClosuresRequest list;
  list.set_parent(session);
  list.set_page_size(1000);
  ASSERT_OK_AND_ASSIGN(const auto closures, Call(&v1::SessionService::Stub::ListClosures, list));
  const auto accepted = std::find_if(closures.closures().begin(), closures.closures().end(),
                                     [](const v1::Closure& c) { return c.state() == v1::Closure::STATE_ACCEPTED; });
  ASSERT_NE(accepted, closures.closures().end()) << "the second lap sees the first again";

  v1::SuspendClosureRequest suspend;
  suspend.set_name(accepted->name());
  ASSERT_OK_AND_ASSIGN(const auto suspended, Call(&v1::SessionService::Stub::SuspendClosure, suspend));
  EXPECT_EQ(suspended.closure().state(), v1::Closure::STATE_SUSPENDED);
  AwaitState(session, v1::Session::STATE_MAPPED);
  EXPECT_NE(database_.SqlValue("SELECT count(*) FROM map_revisions"), revisions);
  ASSERT_OK_AND_ASSIGN(const auto after, Call(&v1::SessionService::Stub::ListClosures, list));
  for (const v1::Closure& closure : after.closures()) {
    if (closure.name() != accepted->name()) continue;
    EXPECT_EQ(closure.state(), v1::Closure::STATE_SUSPENDED);
  }

  v1::ResumeClosureRequest resume;
  resume.set_name(accepted->name());
  ASSERT_OK(Call(&v1::SessionService::Stub::ResumeClosure, resume));
  AwaitState(session, v1::Session::STATE_MAPPED);
  ASSERT_OK_AND_ASSIGN(const auto resumed, Call(&v1::SessionService::Stub::ListClosures, list));
  for (const v1::Closure& closure : resumed.closures()) {
    if (closure.name() != accepted->name()) continue;
    EXPECT_EQ(closure.state(), v1::Closure::STATE_ACCEPTED);
  }
  suspend.set_name(session + "/closures/99999");
  EXPECT_CODE(Call(&v1::SessionService::Stub::SuspendClosure, suspend), absl::StatusCode::kNotFound);
  suspend.set_name("sites/s/sessions/unknown/closures/1");
  EXPECT_CODE(Call(&v1::SessionService::Stub::SuspendClosure, suspend), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace enfilade::testing
