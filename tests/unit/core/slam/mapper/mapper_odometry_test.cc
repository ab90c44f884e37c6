// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/slam/mapper/mapper.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/slam/synthetic_drive.h"

namespace enfilade::slam {
namespace {

using testing::Drive;
using testing::PoseNear;

// Poses by odometry alone: `match_scans` off.
class MapperOdometryTest : public ::testing::Test {
 protected:
  MapperOdometryTest() { options_.match_scans = false; }

  static std::vector<sensor::PairedScan> Log() {
    const auto walls = testing::WallsFromText({"####################",  //
                                               "#                  #",  //
                                               "#     ####         #",  //
                                               "#                  #",  //
                                               "####################"},
                                              1.0);
    return testing::Record(walls, Drive({{1.5, 1.5}, {17.5, 1.5}, {17.5, 3.5}, {2.5, 3.5}}, 0.2), {}, {}, 1);
  }

  SlamOptions options_;
};

TEST_F(MapperOdometryTest, PutsTheFirstKeyframeAtTheOriginAndFollowsTheOdometry) {
  const auto log = Log();
  Mapper mapper(options_);
  SlamMap map;
  for (const sensor::PairedScan& scan : log) EXPECT_TRUE(mapper.AddScan(scan).used);
  mapper.Finish();
  map.Apply(mapper.TakeDelta());
  EXPECT_EQ(map.nodes.at(0).T_map_node, Pose2{});
  const auto trajectory = TrajectoryOf(map);
  ASSERT_EQ(trajectory.size(), log.size());
  for (std::size_t i = 0; i < log.size(); ++i) {
    EXPECT_EQ(trajectory[i].time, log[i].scan.time);
    EXPECT_THAT(trajectory[i].T_map_robot, PoseNear(Between(*log[0].T_odom_robot, *log[i].T_odom_robot), 1e-9, 1e-9));
  }
  EXPECT_GT(map.submaps.size(), 1U);
  for (const auto& [id, submap] : map.submaps) {
    EXPECT_TRUE(submap.finished);
    EXPECT_FALSE(submap.content.empty());
  }
}

TEST_F(MapperOdometryTest, DoesNotUseScansWithoutOdometry) {
  auto log = Log();
  log[3].T_odom_robot.reset();
  Mapper mapper(options_);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(mapper.AddScan(log[i]).used, i != 3);
}

TEST_F(MapperOdometryTest, RendersWallsOccupiedAndRoomsFree) {
  Mapper mapper(options_);
  for (const sensor::PairedScan& scan : Log()) mapper.AddScan(scan);
  const grid::OccupancyGrid grid = mapper.RenderGrid();
  const auto cell_at = [&](double world_x, double world_y) {  // the world's origin is at (-1.5, -1.5) of the map
    const auto& g = grid.geometry;
    const int column = static_cast<int>(std::floor((world_x - 1.5 - g.T_map_grid.x) / g.resolution));
    const int row = static_cast<int>(std::floor((world_y - 1.5 - g.T_map_grid.y) / g.resolution));
    return g.contains(column, row) ? grid.cells[g.index(column, row)] : grid::kUnknownCell;
  };
  EXPECT_GT(grid::ProbabilityOfCell(std::max(cell_at(10.0, 0.98), cell_at(10.0, 1.02))), 0.7);
  EXPECT_LT(grid::ProbabilityOfCell(cell_at(10.0, 1.5)), 0.3);
  EXPECT_LT(grid::ProbabilityOfCell(cell_at(14.0, 2.5)), 0.3);
  EXPECT_EQ(cell_at(8.0, 2.5), grid::kUnknownCell) << "inside the pillar";
}

TEST_F(MapperOdometryTest, RendersTheSameWhetherOftenOrOnce) {
  Mapper often(options_);
  Mapper once(options_);
  int i = 0;
  for (const sensor::PairedScan& scan : Log()) {
    often.AddScan(scan);
    once.AddScan(scan);
    if (++i % 17 == 0) often.RenderGrid();
  }
  EXPECT_EQ(often.RenderGrid(), once.RenderGrid());
}

TEST_F(MapperOdometryTest, RefusesACheckpointThatDoesNotFitTheRows) {
  Mapper mapper(options_);
  SlamMap map;
  for (const sensor::PairedScan& scan : Log()) mapper.AddScan(scan);
  map.Apply(mapper.TakeDelta());
  const std::string checkpoint = mapper.Checkpoint();
  EXPECT_OK(Mapper::Restore(options_, map, checkpoint).status());
  EXPECT_CODE(Mapper::Restore(options_, SlamMap{}, checkpoint).status(), absl::StatusCode::kDataLoss);
  EXPECT_CODE(Mapper::Restore(options_, map, checkpoint.substr(0, checkpoint.size() - 1)).status(),
              absl::StatusCode::kDataLoss);
  EXPECT_CODE(Mapper::Restore(options_, map, "").status(), absl::StatusCode::kDataLoss);
}

TEST_F(MapperOdometryTest, GoesOnTheSameAfterRestoreAtAnyPoint) {
  const auto log = Log();
  const auto run = [&](std::size_t restore_at) {
    Mapper mapper(options_);
    SlamMap map;
    for (std::size_t i = 0; i < log.size(); ++i) {
      if (i == restore_at) {
        map.Apply(mapper.TakeDelta());
        auto restored = Mapper::Restore(options_, map, mapper.Checkpoint());
        EXPECT_OK(restored.status());
        mapper = *std::move(restored);
      }
      mapper.AddScan(log[i]);
    }
    mapper.Finish();
    const grid::OccupancyGrid grid = mapper.RenderGrid();
    map.Apply(mapper.TakeDelta());
    return std::pair(map, grid);
  };
  const auto [expected, expected_grid] = run(log.size());
  for (const std::size_t at : {0UL, 1UL, 30UL, log.size() / 2, log.size() - 1}) {
    const auto [actual, grid] = run(at);
    EXPECT_EQ(actual.nodes, expected.nodes);
    EXPECT_EQ(actual.submaps, expected.submaps);
    EXPECT_EQ(actual.trajectory, expected.trajectory);
    EXPECT_EQ(grid, expected_grid);
  }
}

}  // namespace
}  // namespace enfilade::slam
