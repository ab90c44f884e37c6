// SPDX-License-Identifier: Apache-2.0
// Maps that robots have recorded are merged and split, and that is undone.
#include <thread>

#include "storage/postgres/graph/link_point_store.h"
#include "tests/rpc/rearrange_fixture.h"
#include "tests/support/pose_matchers.h"

namespace enfilade::testing {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;

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
  EXPECT_TRUE(merged.map().pinned());
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
  EXPECT_TRUE(apart.map().pinned());
  EXPECT_TRUE(GetMap("m").pinned());
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
  for (const std::string map : {"m", "m2"}) {
    EXPECT_TRUE(GetMap(map).pinned()) << "what people restore stays, too";
    v1::UpdateMapRequest unpin;
    unpin.mutable_map()->set_name("sites/s/maps/" + map);
    unpin.mutable_update_mask()->add_paths("pinned");
    ASSERT_OK_AND_ASSIGN(const v1::UpdateMapResponse unpinned, Call(&v1::MapService::Stub::UpdateMap, unpin));
    EXPECT_FALSE(unpinned.map().pinned());
    EXPECT_EQ(unpinned.map().display_name(), GetMap(map).display_name());
  }
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

}  // namespace
}  // namespace enfilade::testing
