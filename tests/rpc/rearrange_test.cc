// SPDX-License-Identifier: Apache-2.0
// Maps that robots have recorded are merged and split, and that is undone.
#include <algorithm>
#include <thread>

#include "client/simulator/simulation.h"
#include "core/grid/overlay.h"
#include "core/slam/mapper/log_mapper.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "proto/convert/geometry.h"
#include "proto/convert/record.h"
#include "server/app/mapping/raster_revision.h"
#include "storage/postgres/graph/graph_store.h"
#include "storage/postgres/graph/link_point_store.h"
#include "storage/postgres/maps/revision_store.h"
#include "storage/postgres/sessions/mapping_store.h"
#include "tests/rpc/server_test.h"
#include "tests/support/pose_matchers.h"

namespace enfilade::testing {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::SizeIs;

// A drive through the simulated rooms in two parts, and where the second one begins in the frame of the first.
struct TwoParts {
  std::vector<sensor::Record> first, second;
  Pose2 T_first_second;
};

std::vector<sensor::Record> Numbered(std::vector<sensor::Record> records) {
  for (std::size_t i = 0; i < records.size(); ++i) records[i].sequence = static_cast<std::int64_t>(i) + 1;
  return records;
}

const TwoParts& Drive() {
  static const TwoParts parts = [] {
    simulator::SimulationOptions options = simulator::RoomsOptions();
    options.seed = 18;
    const auto drive = simulator::SimulateRooms(options);
    EXPECT_OK(drive);
    std::vector<sensor::Record> records;
    for (const simulator::SimulatedRecord& entry : drive->records) {
      std::visit([&](const auto& payload) { records.push_back({0, payload}); }, entry.payload);
    }
    const auto cut = records.begin() + static_cast<std::ptrdiff_t>(records.size() * 3 / 10);
    TwoParts two{Numbered({records.begin(), cut}), Numbered({cut, records.end()}), {}};
    slam::LogMapper whole({}, slam::SlamOptions());
    for (const sensor::Record& record : Numbered(records)) whole.Add(record);
    whole.Finish();
    slam::SlamMap map;
    map.Apply(whole.TakeDelta());
    TimeNs begin = 0;
    for (const sensor::Record& record : two.second) {
      if (const auto* scan = std::get_if<sensor::LaserScan>(&record.payload); scan != nullptr && begin == 0) {
        begin = scan->time;
      }
    }
    const std::vector<slam::StampedPose> trajectory = slam::TrajectoryOf(map);
    two.T_first_second = std::min_element(trajectory.begin(), trajectory.end(), [&](const auto& a, const auto& b) {
                           return std::abs(a.time - begin) < std::abs(b.time - begin);
                         })->T_map_robot;
    return two;
  }();
  return parts;
}

class RearrangeTest : public ServerTest {
 protected:
  // The first part in map "m", the second one in map "m2"; a link point says where m2 lies in m.
  void MapBoth() {
    v1::CreateMapRequest request;
    request.set_parent("sites/s");
    request.set_map_id("m2");
    request.mutable_map()->set_display_name("Second part");
    ASSERT_OK(Call(&v1::MapService::Stub::CreateMap, request));
    first_ = CreateSession(true);
    Map(first_, Drive().first);
    second_ = CreateSessionIn("sites/s/maps/m2");
    Map(second_, Drive().second);
    Link("between", Drive().T_first_second, {});
  }
  std::string CreateSessionIn(const std::string& map) {
    v1::CreateSessionRequest request;
    request.set_parent("sites/s");
    request.mutable_session()->set_robot("sites/s/robots/r");
    request.mutable_session()->set_map(map);
    const auto response = Call(&v1::SessionService::Stub::CreateSession, request);
    EXPECT_OK(response);
    return response.ok() ? response->session().name() : "";
  }
  void Map(const std::string& session, const std::vector<sensor::Record>& log) {
    TestStream stream(*connection_, session);
    std::vector<v1::Record> batch;
    for (const sensor::Record& record : log) {
      batch.push_back(convert::ToProto(record));
      if (batch.size() < 200 && &record != &log.back()) continue;
      ASSERT_TRUE(stream.SendBatch(batch));
      batch.clear();
    }
    ASSERT_TRUE(stream.AwaitAcknowledged(static_cast<std::int64_t>(log.size())));
    ASSERT_OK(FinishSession(session, static_cast<std::int64_t>(log.size())));
    AwaitState(session, v1::Session::STATE_MAPPED);
  }
  void Link(const std::string& id, const Pose2& in_m, const Pose2& in_m2) {
    v1::CreateLinkPointRequest request;
    request.set_parent("sites/s");
    request.set_link_point_id(id);
    request.mutable_link_point()->set_kind(v1::LinkPoint::KIND_DOOR);
    for (const auto& [map, pose] : {std::pair("sites/s/maps/m", in_m), std::pair("sites/s/maps/m2", in_m2)}) {
      v1::Anchor& anchor = *request.mutable_link_point()->add_anchors();
      anchor.set_map(map);
      *anchor.mutable_pose_map_place() = convert::ToProto(PoseWithCovariance{pose, graph::DefaultAnchorCovariance()});
    }
    ASSERT_OK(Call(&v1::LinkPointService::Stub::CreateLinkPoint, request));
  }

  absl::StatusOr<v1::MergeMapsResponse> Merge(const std::string& kept = "m", const std::string& merged = "m2") {
    v1::MergeMapsRequest request;
    request.set_name("sites/s/maps/" + kept);
    request.set_merged_map("sites/s/maps/" + merged);
    return Call(&v1::MapService::Stub::MergeMaps, request);
  }
  absl::StatusOr<v1::UndoRearrangementResponse> Undo(const std::string& name) {
    v1::UndoRearrangementRequest request;
    request.set_name(name);
    return Call(&v1::MapService::Stub::UndoRearrangement, request);
  }
  v1::Map GetMap(const std::string& id) {
    v1::GetMapRequest request;
    request.set_name("sites/s/maps/" + id);
    const auto response = Call(&v1::MapService::Stub::GetMap, request);
    EXPECT_OK(response);
    return response.ok() ? response->map() : v1::Map();
  }

  // Of the graph: what watchers are told of.
  int CountRearrangedVersions() {
    v1::ListGraphVersionsRequest request;
    request.set_parent("sites/s");
    request.set_page_size(1000);
    const auto response = Call(&v1::GraphService::Stub::ListGraphVersions, request);
    EXPECT_OK(response);
    if (!response.ok()) return -1;
    const auto& versions = response->graph_versions();
    return static_cast<int>(std::count_if(versions.begin(), versions.end(), [](const v1::GraphVersion& version) {
      return version.cause() == v1::GraphVersion::CAUSE_REARRANGED;
    }));
  }
  std::vector<slam::StampedPose> Trajectory(const std::string& session) {
    const auto mapping = storage::postgres::MappingStore(*pool_).ReadTrajectory(Soon(), site_, IdOf(session));
    EXPECT_OK(mapping);
    return mapping.ok() ? mapping->poses : std::vector<slam::StampedPose>();
  }
  std::vector<Pose2> WorldTrajectory(const std::string& session) {
    const std::string map = GetSession(session).map();
    const auto places = storage::postgres::GraphStore(*pool_).GetPlaces(Soon(), site_, {MapId(map.substr(13))});
    EXPECT_OK(places);
    EXPECT_THAT(*places, SizeIs(1));
    std::vector<Pose2> world;
    for (const slam::StampedPose& pose : Trajectory(session)) {
      world.push_back(places->front().T_world_map.pose * pose.T_map_robot);
    }
    return world;
  }
  grid::OccupancyGrid Published(const std::string& map) {
    const storage::postgres::RevisionStore revisions(*pool_);
    const auto revision = revisions.Get(Soon(), site_, MapId(map), 0);
    EXPECT_OK(revision);
    const auto raster = server::ReadRaster(Soon(), revisions, *revision);
    EXPECT_OK(raster);
    return grid::ResampleToLattice(grid::ToOccupancyGrid(*raster), 0.05).value();
  }
  std::string HashOf(const std::string& map) {
    const auto revision = storage::postgres::RevisionStore(*pool_).Get(Soon(), site_, MapId(map), 0);
    EXPECT_OK(revision);
    return revision->content_sha256;
  }
  static SessionId IdOf(const std::string& name) { return SessionId(name.substr(name.rfind('/') + 1)); }

  const SiteId site_{"s"};
  std::string first_, second_;
};

void ExpectSame(const std::vector<Pose2>& a, const std::vector<Pose2>& b) {
  ASSERT_GT(a.size(), 50U);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) ASSERT_THAT(a[i], PoseNear(b[i], 1e-9, 1e-9)) << i;
}

// The share of the occupied cells of `wanted`, moved by T, that have an occupied cell of `grid` within two cells.
double ShareOfWalls(const grid::OccupancyGrid& grid, const Pose2& T_grid_wanted, const grid::OccupancyGrid& wanted) {
  const double r = grid.geometry.resolution;
  int all = 0, found = 0;
  for (int row = 0; row < wanted.geometry.height; ++row) {
    for (int column = 0; column < wanted.geometry.width; ++column) {
      if (wanted.cells[wanted.geometry.index(column, row)] <= 165) continue;
      const Eigen::Vector2d cell =
          T_grid_wanted * (wanted.geometry.T_map_grid * Eigen::Vector2d((column + 0.5) * r, (row + 0.5) * r));
      const Eigen::Vector2d at = Inverse(grid.geometry.T_map_grid) * cell / r;
      bool near = false;
      for (int y = -2; y <= 2; ++y) {
        for (int x = -2; x <= 2; ++x) {
          const int c = static_cast<int>(std::floor(at.x())) + x, l = static_cast<int>(std::floor(at.y())) + y;
          near = near || (grid.geometry.contains(c, l) && grid.cells[grid.geometry.index(c, l)] > 165);
        }
      }
      ++all;
      found += near;
    }
  }
  return all == 0 ? 0.0 : static_cast<double>(found) / all;
}

TEST_F(RearrangeTest, MergesRecordedMapsSplitsThemAndUndoesBoth) {
  MapBoth();
  const std::vector<Pose2> first_world = WorldTrajectory(first_), second_world = WorldTrajectory(second_);
  const std::vector<slam::StampedPose> second_before = Trajectory(second_);
  const grid::OccupancyGrid first_grid = Published("m"), second_grid = Published("m2");
  const std::string m_before = HashOf("m"), m2_before = HashOf("m2");

  ASSERT_OK_AND_ASSIGN(const v1::MergeMapsResponse merged, Merge());
  EXPECT_EQ(merged.map().name(), "sites/s/maps/m");
  EXPECT_THAT(merged.rearrangement().reason(), HasSubstr("map m2 merged into map m"));
  EXPECT_EQ(GetSession(second_).map(), "sites/s/maps/m");
  EXPECT_EQ(GetMap("m2").name(), "sites/s/maps/m") << "the old name leads to the other map";
  ExpectSame(WorldTrajectory(first_), first_world);
  ExpectSame(WorldTrajectory(second_), second_world);
  const grid::OccupancyGrid both = Published("m");
  EXPECT_GT(ShareOfWalls(both, {}, first_grid), 0.99);
  EXPECT_GT(ShareOfWalls(both, Drive().T_first_second, second_grid), 0.98);
  EXPECT_EQ(HashOf("m2"), HashOf("m"));
  EXPECT_THAT(storage::postgres::LinkPointStore(*pool_).Get(Soon(), site_, LinkPointId("between")).status().message(),
              HasSubstr("does not exist"));

  // So do poses in its frame.
  v1::GetGlobalPoseRequest pose;
  pose.mutable_map_pose()->set_map("sites/s/maps/m2");
  *pose.mutable_map_pose()->mutable_pose_map_robot() =
      convert::ToProto(PoseWithCovariance{{1, 2, 0.3}, Eigen::Matrix3d::Zero()});
  ASSERT_OK_AND_ASSIGN(const auto global, Call(&v1::GraphService::Stub::GetGlobalPose, pose));
  EXPECT_THAT(convert::FromProto(global.global_pose().pose_world_robot().pose()),
              PoseNear(Drive().T_first_second * Pose2{1, 2, 0.3}, 1e-9, 1e-9));
  v1::TransformPosesRequest transform;
  transform.set_source_map("sites/s/maps/m2");
  transform.set_target_map("sites/s/maps/m");
  ASSERT_OK_AND_ASSIGN(const auto transformed, Call(&v1::GraphService::Stub::TransformPoses, transform));
  EXPECT_THAT(convert::FromProto(transformed.pose_target_source().pose()),
              PoseNear(Drive().T_first_second, 1e-9, 1e-9));
  v1::FindRoutesRequest routes;
  routes.set_start_map("sites/s/maps/m2");
  routes.set_goal_map("sites/s/maps/m");
  routes.mutable_pose_map_start();
  *routes.mutable_pose_map_goal() = convert::ToProto(Drive().T_first_second);
  ASSERT_OK_AND_ASSIGN(const auto found, Call(&v1::GraphService::Stub::FindRoutes, routes));
  ASSERT_EQ(found.routes_size(), 1);
  EXPECT_NEAR(found.routes(0).length_m(), 0.0, 1e-9);

  // Split again by the sessions.
  v1::SplitMapRequest split;
  split.set_name("sites/s/maps/m");
  split.add_sessions(second_);
  split.set_map_id("m3");
  ASSERT_OK_AND_ASSIGN(const v1::SplitMapResponse apart, Call(&v1::MapService::Stub::SplitMap, split));
  EXPECT_EQ(apart.map().name(), "sites/s/maps/m3");
  EXPECT_EQ(GetSession(second_).map(), "sites/s/maps/m3");
  ExpectSame(WorldTrajectory(second_), second_world);
  EXPECT_EQ(HashOf("m"), m_before);
  EXPECT_GT(ShareOfWalls(Published("m3"), Drive().T_first_second, second_grid), 0.98);
  EXPECT_EQ(apart.rearrangement().changed_link_points_size(), 1);

  ASSERT_OK(Undo(apart.rearrangement().name()));
  EXPECT_EQ(GetSession(second_).map(), "sites/s/maps/m");
  ASSERT_OK_AND_ASSIGN(const v1::UndoRearrangementResponse undone, Undo(merged.rearrangement().name()));
  EXPECT_NE(undone.rearrangement().undo_graph_version(), 0);
  EXPECT_EQ(HashOf("m"), m_before);
  EXPECT_EQ(HashOf("m2"), m2_before);
  EXPECT_EQ(GetMap("m2").display_name(), "Second part");
  const std::vector<slam::StampedPose> second_after = Trajectory(second_);
  ASSERT_EQ(second_after.size(), second_before.size());
  for (std::size_t i = 0; i < second_after.size(); ++i) {
    ASSERT_EQ(second_after[i].T_map_robot, second_before[i].T_map_robot) << "bit by bit";
  }
  EXPECT_OK(storage::postgres::LinkPointStore(*pool_).Get(Soon(), site_, LinkPointId("between")));
  EXPECT_STATUS(Undo(merged.rearrangement().name()), absl::StatusCode::kFailedPrecondition, HasSubstr("already"));

  v1::ListRearrangementsRequest list;
  list.set_parent("sites/s");
  list.set_page_size(1);
  ASSERT_OK_AND_ASSIGN(const auto page, Call(&v1::MapService::Stub::ListRearrangements, list));
  EXPECT_EQ(page.rearrangements(0).name(), apart.rearrangement().name());
  EXPECT_FALSE(page.next_page_token().empty());
}

TEST_F(RearrangeTest, ASessionIsCutInTwoAndMadeWholeAgain) {
  MapBoth();
  const std::vector<Pose2> world = WorldTrajectory(second_);
  const std::vector<slam::StampedPose> before = Trajectory(second_);
  const grid::OccupancyGrid grid = Published("m2");
  const std::string hash = HashOf("m2");
  v1::SplitMapRequest split;
  split.set_name("sites/s/maps/m2");
  v1::SessionCut& cut = *split.add_cuts();
  cut.set_session(second_);
  cut.set_first_sequence(static_cast<std::int64_t>(Drive().second.size() / 8));
  ASSERT_OK_AND_ASSIGN(const v1::SplitMapResponse apart, Call(&v1::MapService::Stub::SplitMap, split));
  ASSERT_EQ(apart.rearrangement().cut_sessions_size(), 1);
  const std::string rest = apart.rearrangement().cut_sessions(0).rest();
  EXPECT_EQ(GetSession(second_).map(), "sites/s/maps/m2");
  EXPECT_EQ(GetSession(rest).map(), apart.map().name());
  EXPECT_EQ(GetSession(rest).state(), v1::Session::STATE_MAPPED);
  std::vector<Pose2> both = WorldTrajectory(second_);
  const std::vector<Pose2> behind = WorldTrajectory(rest);
  EXPECT_GT(both.size(), world.size() / 16);
  EXPECT_GT(behind.size(), world.size() / 2);
  both.insert(both.end(), behind.begin(), behind.end());
  ExpectSame(both, world);
  // The first part has not been everywhere; together they have all.
  const grid::OccupancyGrid head_grid = Published("m2"), rest_grid = Published(IdOf(apart.map().name()).value());
  EXPECT_LT(ShareOfWalls(head_grid, {}, grid), 0.95);
  EXPECT_GT(ShareOfWalls(grid, {}, head_grid), 0.98);
  EXPECT_GT(ShareOfWalls(grid::Overlay(head_grid, rest_grid).value(), {}, grid), 0.98);

  ASSERT_OK(Undo(apart.rearrangement().name()));
  EXPECT_EQ(HashOf("m2"), hash);
  const std::vector<slam::StampedPose> after = Trajectory(second_);
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) ASSERT_EQ(after[i].T_map_robot, before[i].T_map_robot) << "bit by bit";
  v1::GetSessionRequest get;
  get.set_name(rest);
  EXPECT_CODE(Call(&v1::SessionService::Stub::GetSession, get), absl::StatusCode::kNotFound);
}

TEST_F(RearrangeTest, TwoAtOnceOneWinsAndTheMergedSessionCanBeMappedAgain) {
  MapBoth();
  const std::vector<Pose2> before = WorldTrajectory(second_);
  absl::Status a, b;
  std::thread other([&] { a = Merge().status(); });
  b = Merge().status();
  other.join();
  EXPECT_NE(a.ok(), b.ok()) << a << b;
  EXPECT_THAT((a.ok() ? b : a).code(), AnyOf(absl::StatusCode::kAborted, absl::StatusCode::kFailedPrecondition));
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM rearrangements"), "1");

  // Its graph is solved again in the new frame.
  v1::ListClosuresRequest list;
  list.set_parent(second_);
  list.set_page_size(1000);
  ASSERT_OK_AND_ASSIGN(const auto closures, Call(&v1::SessionService::Stub::ListClosures, list));
  for (const v1::Closure& closure : closures.closures()) {
    if (closure.state() != v1::Closure::STATE_ACCEPTED) continue;
    v1::SuspendClosureRequest suspend;
    suspend.set_name(closure.name());
    ASSERT_OK(Call(&v1::SessionService::Stub::SuspendClosure, suspend));
    AwaitState(second_, v1::Session::STATE_MAPPED);
    break;
  }
  const std::vector<Pose2> after = WorldTrajectory(second_);
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) ASSERT_THAT(after[i], PoseNear(before[i], 0.5, 0.2)) << i;
}

TEST_F(RearrangeTest, RefusesWhatCannotBe) {
  v1::CreateMapRequest request;
  request.set_parent("sites/s");
  request.set_map_id("m2");
  request.mutable_map()->set_display_name("Second part");
  ASSERT_OK(Call(&v1::MapService::Stub::CreateMap, request));
  EXPECT_STATUS(Merge("m", "m"), absl::StatusCode::kInvalidArgument, HasSubstr("with itself"));
  EXPECT_STATUS(Merge("m", "none"), absl::StatusCode::kNotFound, HasSubstr("none"));
  EXPECT_STATUS(Merge(), absl::StatusCode::kFailedPrecondition, HasSubstr("no link points lead"));
  Link("between", {1, 2, 0}, {});
  const std::string session = CreateSessionIn("sites/s/maps/m2");
  EXPECT_STATUS(Merge(), absl::StatusCode::kFailedPrecondition, HasSubstr("still recording or being mapped"));
  v1::SplitMapRequest split;
  split.set_name("sites/s/maps/m2");
  EXPECT_STATUS(Call(&v1::MapService::Stub::SplitMap, split), absl::StatusCode::kFailedPrecondition,
                HasSubstr("no session leaves"));
  split.add_sessions("sites/s/sessions/none");
  EXPECT_STATUS(Call(&v1::MapService::Stub::SplitMap, split), absl::StatusCode::kNotFound, HasSubstr("none"));
  split.set_sessions(0, "sites/other/sessions/none");
  EXPECT_STATUS(Call(&v1::MapService::Stub::SplitMap, split), absl::StatusCode::kInvalidArgument, HasSubstr("site"));
  EXPECT_STATUS(Undo("sites/s/rearrangements/none"), absl::StatusCode::kNotFound, HasSubstr("rearrangements/none"));
  ASSERT_OK(FinishSession(session, 0));
  AwaitState(session, v1::Session::STATE_MAPPED);
  ASSERT_OK_AND_ASSIGN(const v1::MergeMapsResponse merged, Merge());  // without anything mapped
  EXPECT_EQ(GetSession(session).map(), "sites/s/maps/m");
  EXPECT_STATUS(Merge(), absl::StatusCode::kFailedPrecondition, HasSubstr("was merged into"));
  ASSERT_OK(Undo(merged.rearrangement().name()));
  EXPECT_EQ(GetSession(session).map(), "sites/s/maps/m2");
  EXPECT_STATUS(Undo(merged.rearrangement().name()), absl::StatusCode::kFailedPrecondition, HasSubstr("already"));

  ASSERT_OK_AND_ASSIGN(const v1::MergeMapsResponse again, Merge());
  v1::DeleteSessionRequest edit;
  edit.set_name(session);
  ASSERT_OK(Call(&v1::SessionService::Stub::DeleteSession, edit));
  EXPECT_STATUS(Undo(again.rearrangement().name()), absl::StatusCode::kFailedPrecondition,
                HasSubstr(IdOf(session).value()));
  EXPECT_EQ(GetMap("m2").name(), "sites/s/maps/m") << "nothing is undone";
  request.set_map_id("above");
  request.mutable_map()->set_display_name("Above");
  request.mutable_map()->set_level(1);
  ASSERT_OK(Call(&v1::MapService::Stub::CreateMap, request));
  EXPECT_STATUS(Merge("m", "above"), absl::StatusCode::kInvalidArgument, HasSubstr("level"));
  EXPECT_EQ(CountRearrangedVersions(), 3) << "two merges and an undo; nothing of what was refused";
}

}  // namespace
}  // namespace enfilade::testing
