// SPDX-License-Identifier: Apache-2.0
// Several sessions in one map: one after the other, at the same time, and on an imported map.
#include <algorithm>

#include "client/simulator/simulation.h"
#include "core/grid/overlay.h"
#include "core/slam/mapper/log_mapper.h"
#include "proto/convert/geometry.h"
#include "proto/convert/record.h"
#include "server/app/mapping/raster_revision.h"
#include "storage/postgres/graph/robot_pose_store.h"
#include "storage/postgres/maps/blob_store.h"
#include "storage/postgres/maps/revision_store.h"
#include "storage/postgres/sessions/mapping_store.h"
#include "tests/rpc/server_test.h"
#include "tests/support/pose_matchers.h"

namespace enfilade::testing {
namespace {

using server::ReadRaster;
using server::ToRevision;

// A drive of one lap through the simulated rooms, to be cut in two before the robot has seen all of them.
struct Log {
  std::vector<sensor::Record> records;
  std::size_t cut = 0;  // the second part's first record

  explicit Log(std::uint64_t seed) {
    simulator::SimulationOptions options = simulator::RoomsOptions();
    options.seed = seed;
    const auto drive = simulator::SimulateRooms(options);
    EXPECT_OK(drive);
    for (const simulator::SimulatedRecord& entry : drive->records) {
      std::visit([&](const auto& payload) { records.push_back({0, payload}); }, entry.payload);
    }
    cut = records.size() * 3 / 10;
  }

  // With sequences from 1.
  std::vector<sensor::Record> Part(std::size_t begin, std::size_t end) const {
    std::vector<sensor::Record> part(records.begin() + static_cast<std::ptrdiff_t>(begin),
                                     records.begin() + static_cast<std::ptrdiff_t>(end));
    for (std::size_t i = 0; i < part.size(); ++i) part[i].sequence = static_cast<std::int64_t>(i) + 1;
    return part;
  }
  std::vector<sensor::Record> First() const { return Part(0, cut); }
  std::vector<sensor::Record> Second() const { return Part(cut, records.size()); }
};

struct Offline {
  std::vector<slam::StampedPose> trajectory;
  grid::OccupancyGrid grid;
};

Offline MapOffline(const std::vector<sensor::Record>& log) {
  slam::LogMapper mapper({}, slam::SlamOptions());
  for (const sensor::Record& record : log) mapper.Add(record);
  mapper.Finish();
  slam::SlamMap map;
  map.Apply(mapper.TakeDelta());
  return {slam::TrajectoryOf(map), mapper.RenderGrid()};
}

// By one session over both halves.
const Offline& OneSession() {
  static const Offline offline = [] {
    const Log log(1);
    return MapOffline(log.Part(0, log.records.size()));
  }();
  return offline;
}

Pose2 PoseAt(const std::vector<slam::StampedPose>& trajectory, TimeNs time) {
  return std::min_element(trajectory.begin(), trajectory.end(),
                          [&](const slam::StampedPose& a, const slam::StampedPose& b) {
                            return std::abs(a.time - time) < std::abs(b.time - time);
                          })
      ->T_map_robot;
}

Eigen::Matrix3d Covariance(double sigma, double yaw_sigma) {
  return Eigen::Vector3d(sigma * sigma, sigma * sigma, yaw_sigma * yaw_sigma).asDiagonal();
}

class ExistingMapTest : public ServerTest {
 protected:
  std::string CreateSessionAt(const Pose2& T_map_robot) {
    v1::CreateSessionRequest request;
    request.set_parent("sites/s");
    request.mutable_session()->set_robot("sites/s/robots/r");
    request.mutable_session()->set_map("sites/s/maps/m");
    *request.mutable_session()->mutable_entry()->mutable_pose_map_robot() =
        convert::ToProto(PoseWithCovariance{T_map_robot, Covariance(0.2, 0.1)});
    const auto response = Call(&v1::SessionService::Stub::CreateSession, request);
    EXPECT_OK(response);
    return response.ok() ? response->session().name() : "";
  }

  void Send(TestStream& stream, const std::vector<sensor::Record>& log, std::size_t begin, std::size_t end) {
    std::vector<v1::Record> batch;
    for (std::size_t i = begin; i < end; ++i) {
      batch.push_back(convert::ToProto(log[i]));
      if (batch.size() < 200 && i + 1 < end) continue;
      ASSERT_TRUE(stream.SendBatch(batch));
      batch.clear();
    }
    ASSERT_TRUE(stream.AwaitAcknowledged(static_cast<std::int64_t>(end)));
  }

  void Map(const std::string& session, const std::vector<sensor::Record>& log) {
    TestStream stream(*connection_, session);
    Send(stream, log, 0, log.size());
    ASSERT_OK(FinishSession(session, static_cast<std::int64_t>(log.size())));
    AwaitState(session, v1::Session::STATE_MAPPED);
  }

  std::vector<slam::StampedPose> Trajectory(const std::string& session) {
    const auto mapping = storage::postgres::MappingStore(*pool_).ReadTrajectory(Soon(), site_, IdOf(session));
    EXPECT_OK(mapping);
    return mapping.ok() ? mapping->poses : std::vector<slam::StampedPose>();
  }

  grid::OccupancyGrid Published() {
    const auto revision = revisions_.Get(Soon(), site_, map_, 0);
    EXPECT_OK(revision);
    const auto raster = ReadRaster(Soon(), revisions_, *revision);
    EXPECT_OK(raster);
    return grid::ResampleToLattice(grid::ToOccupancyGrid(*raster), 0.05).value();
  }

  static SessionId IdOf(const std::string& session) { return SessionId(session.substr(session.rfind('/') + 1)); }

  const SiteId site_{"s"};
  const MapId map_{"m"};
  storage::postgres::RevisionStore revisions_{*pool_};
};

// The share of the occupied cells of `wanted` that have an occupied cell of `grid` within 0.1 m.
double ShareOfWallsIn(const grid::OccupancyGrid& grid, const grid::OccupancyGrid& wanted) {
  const auto occupied = [](const grid::OccupancyGrid& g, int column, int row) {
    return g.geometry.contains(column, row) && g.cells[g.geometry.index(column, row)] > 165;
  };
  const double r = wanted.geometry.resolution;
  const int dx = static_cast<int>(std::lround((wanted.geometry.T_map_grid.x - grid.geometry.T_map_grid.x) / r));
  const int dy = static_cast<int>(std::lround((wanted.geometry.T_map_grid.y - grid.geometry.T_map_grid.y) / r));
  int all = 0;
  int found = 0;
  for (int row = 0; row < wanted.geometry.height; ++row) {
    for (int column = 0; column < wanted.geometry.width; ++column) {
      if (!occupied(wanted, column, row)) continue;
      ++all;
      bool near = false;
      for (int y = -2; y <= 2; ++y) {
        for (int x = -2; x <= 2; ++x) near = near || occupied(grid, column + dx + x, row + dy + y);
      }
      found += near;
    }
  }
  return all == 0 ? 0.0 : static_cast<double>(found) / all;
}

double WorstDifference(const std::vector<slam::StampedPose>& trajectory, const std::vector<slam::StampedPose>& wanted) {
  double worst = 0.0;
  for (const slam::StampedPose& pose : trajectory) {
    worst = std::max(worst, Between(PoseAt(wanted, pose.time), pose.T_map_robot).translation().norm());
  }
  return worst;
}

TEST_F(ExistingMapTest, ASecondSessionGoesOnWhereTheFirstOneEnded) {
  const Log log(1);
  const std::string first = CreateSession(true);
  Map(first, log.First());
  const grid::OccupancyGrid after_first = Published();
  const Pose2 end = Trajectory(first).back().T_map_robot;
  const std::string second = CreateSessionAt({end.x + 0.3, end.y - 0.2, end.yaw + 0.1});
  Map(second, log.Second());

  const std::vector<slam::StampedPose> trajectory = Trajectory(second);
  ASSERT_GT(trajectory.size(), 100U);
  EXPECT_LT(WorstDifference(trajectory, OneSession().trajectory), 0.15);
  const grid::OccupancyGrid published = Published();
  EXPECT_GT(ShareOfWallsIn(published, after_first), 0.98);
  EXPECT_GT(ShareOfWallsIn(published, OneSession().grid), 0.98);
  EXPECT_GT(ShareOfWallsIn(OneSession().grid, published), 0.98) << "no walls beside the true ones";
  EXPECT_LT(ShareOfWallsIn(after_first, published), 0.98) << "the second part has seen more";

  ASSERT_OK_AND_ASSIGN(const storage::RobotPose pose,
                       storage::postgres::RobotPoseStore(*pool_).Get(Soon(), site_, RobotId("r")));
  EXPECT_EQ(pose.map, map_);
  EXPECT_EQ(pose.session, IdOf(second));
  EXPECT_EQ(pose.time, trajectory.back().time);
  EXPECT_THAT(pose.T_map_robot.pose, PoseNear(trajectory.back().T_map_robot, 1e-6, 1e-6));
  EXPECT_LT(std::sqrt(pose.T_map_robot.covariance(0, 0)), 0.2);
}

TEST_F(ExistingMapTest, TwoSessionsAtOnceLoseNothing) {
  server::ServerOptions options = Options();
  options.mapping.workers = 2;
  options.mapping.checkpoint_interval_s = 0.01;
  options.mapping.revision_interval_s = 0.05;
  Restart(options);
  const Log log(1);
  const std::vector<sensor::Record> first_log = log.First();
  const std::vector<sensor::Record> second_log = log.Second();
  const std::string first = CreateSession(true);
  TimeNs begin = 0;
  for (const sensor::Record& record : second_log) {
    if (const auto* scan = std::get_if<sensor::LaserScan>(&record.payload); scan != nullptr && begin == 0)
      begin = scan->time;
  }
  const std::string second = CreateSessionAt(PoseAt(OneSession().trajectory, begin));
  {
    TestStream first_stream(*connection_, first);
    TestStream second_stream(*connection_, second);
    constexpr std::size_t kParts = 10;
    for (std::size_t i = 0; i < kParts; ++i) {
      Send(first_stream, first_log, first_log.size() * i / kParts, first_log.size() * (i + 1) / kParts);
      Send(second_stream, second_log, second_log.size() * i / kParts, second_log.size() * (i + 1) / kParts);
    }
  }
  ASSERT_OK(FinishSession(first, static_cast<std::int64_t>(first_log.size())));
  ASSERT_OK(FinishSession(second, static_cast<std::int64_t>(second_log.size())));
  AwaitState(first, v1::Session::STATE_MAPPED);
  AwaitState(second, v1::Session::STATE_MAPPED);

  EXPECT_LT(WorstDifference(Trajectory(second), OneSession().trajectory), 0.3);
  const grid::OccupancyGrid published = Published();
  EXPECT_GT(ShareOfWallsIn(published, OneSession().grid), 0.95);
  // All that the first session has seen by itself is there.
  const grid::OccupancyGrid first_alone = MapOffline(first_log).grid;
  EXPECT_GT(ShareOfWallsIn(published, first_alone), 0.95);
  ASSERT_OK_AND_ASSIGN(const storage::LayersBeside layers,
                       revisions_.ReadLayersBeside(Soon(), site_, map_, IdOf(second)));
  ASSERT_EQ(layers.below.size() + layers.above.size(), 1U);
  const storage::MapLayer& layer = layers.below.empty() ? layers.above.front() : layers.below.front();
  ASSERT_OK_AND_ASSIGN(const server::RasterRevision expected, ToRevision(grid::FromOccupancyGrid(first_alone)));
  EXPECT_EQ(layer.session, IdOf(first));
  EXPECT_EQ(server::ContentHash(layer.raster.header, layer.raster.tiles), expected.revision.content_sha256)
      << "the first session's layer is what it would be alone";
}

TEST_F(ExistingMapTest, ASessionOnAnImportedMapKeepsWhatItDoesNotSee) {
  const Log log(1);
  const Offline first_part = MapOffline(log.First());
  // Coarser than SLAM's, and with a wall that no robot has ever seen.
  ASSERT_OK_AND_ASSIGN(grid::OccupancyGrid imported, grid::ResampleToLattice(first_part.grid, 0.1));
  grid::OccupancyGrid wall;
  wall.geometry = {0.1, {-30.0, 0.0, 0.0}, 1, 20};
  wall.cells.assign(20, 250);
  ASSERT_OK_AND_ASSIGN(imported, grid::Overlay(imported, wall));
  ASSERT_OK_AND_ASSIGN(server::RasterRevision raster, ToRevision(grid::FromOccupancyGrid(imported)));
  raster.revision.source = storage::RevisionSource::kImport;
  ASSERT_OK(PutTiles(Soon(), storage::postgres::BlobStore(*pool_), site_, raster, {}));
  ASSERT_OK(revisions_.Add(Soon(), site_, map_, raster.revision, {}));

  const std::string session = CreateSessionAt(first_part.trajectory.back().T_map_robot);
  Map(session, log.Second());
  EXPECT_LT(WorstDifference(Trajectory(session), OneSession().trajectory), 0.2);
  const grid::OccupancyGrid published = Published();
  ASSERT_OK_AND_ASSIGN(const grid::OccupancyGrid far_wall, grid::ResampleToLattice(wall, 0.05));
  EXPECT_EQ(ShareOfWallsIn(published, far_wall), 1.0);
  EXPECT_GT(ShareOfWallsIn(published, OneSession().grid), 0.95);
}

}  // namespace
}  // namespace enfilade::testing
