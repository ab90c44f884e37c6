// SPDX-License-Identifier: Apache-2.0
#include "core/slam/submaps/finished_submap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/support/status_assertions.h"

namespace enfilade::slam {
namespace {

using ::testing::HasSubstr;

SubmapNode NodeAt(std::int64_t id, double x, double y, double length, bool carried) {
  return {id, carried, length, {x, y, 0.1}, Eigen::Matrix3d::Identity()};
}

SubmapContent EmptyContent() { return {{}, {}, {}, SubmapGrid(0.1, {})}; }

// Cells of 0.1 m, known from (-0.2, 0.3) to (0.4, 0.5).
grid::OccupancyGrid SmallMap() {
  grid::OccupancyGrid grid;
  grid.geometry.resolution = 0.1;
  grid.geometry.width = 6;
  grid.geometry.height = 2;
  grid.geometry.T_map_grid = {-0.2, 0.3, 0.0};
  grid.cells.assign(12, grid::CellFromProbability(0.2));
  grid.cells[7] = grid::CellFromProbability(0.9);
  return grid;
}

TEST(FinishSubmap, AddsTheLengthOfItsOwnKeyframesAndFindsTheFarthestOfAll) {
  const std::vector<SubmapNode> nodes{NodeAt(4, -6.0, 8.0, 100.0, true), NodeAt(5, 0.0, 0.0, 0.5, false),
                                      NodeAt(6, 3.0, 4.0, 0.25, false)};
  const FinishedSubmap submap = FinishSubmap({1.0, 2.0, 3.0}, 9, "bytes", nodes, std::nullopt);
  EXPECT_DOUBLE_EQ(submap.length, 0.75) << "the carried keyframe's length belongs to the submap before";
  EXPECT_DOUBLE_EQ(submap.extent, 10.0) << "the carried keyframe counts";
  EXPECT_EQ(submap.nodes, nodes);
  EXPECT_EQ(submap.version, 9);
  EXPECT_EQ(submap.content, "bytes");
  EXPECT_EQ(submap.T_map_submap, (Pose2{1.0, 2.0, 3.0}));
  EXPECT_TRUE(submap.known.isEmpty());
}

TEST(FinishExistingMap, HasTheBoxOfItsCellsAndNoKeyframes) {
  SubmapContent content = EmptyContent();
  content.grid = SubmapGrid::FromOccupancy(SmallMap(), {});
  const FinishedSubmap submap = FinishExistingMap(1, content);
  EXPECT_TRUE(submap.nodes.empty());
  EXPECT_EQ(submap.T_map_submap, Pose2{});
  EXPECT_EQ(submap.extent, 0.0);
  EXPECT_LT((submap.known.min() - Eigen::Vector2d(-0.2, 0.3)).norm(), 1e-12);
  EXPECT_LT((submap.known.max() - Eigen::Vector2d(0.4, 0.5)).norm(), 1e-12);
}

TEST(FinishExistingMap, WithoutCellsHasAnEmptyBox) {
  EXPECT_TRUE(FinishExistingMap(1, EmptyContent()).known.isEmpty());
}

TEST(RestoreFinishedSubmap, GivesBackWhatWasFinished) {
  SubmapContent own = EmptyContent();
  own.nodes = {NodeAt(0, 0.0, 0.0, 0.0, false), NodeAt(1, 0.5, 0.5, 0.7, false)};
  own.next = NextSubmap{{0.5, 0.5, 0.2}, 3.0 * Eigen::Matrix3d::Identity()};
  SubmapContent existing = EmptyContent();
  existing.grid = SubmapGrid::FromOccupancy(SmallMap(), {});
  const FinishedSubmap finished[] = {FinishSubmap({4.0, 5.0, 0.6}, 3, Encode(own), own.nodes, own.next),
                                     FinishExistingMap(2, existing)};
  for (const FinishedSubmap& expected : finished) {
    const SlamSubmap row{7, expected.version, expected.T_map_submap, true, expected.content};
    ASSERT_OK_AND_ASSIGN(const FinishedSubmap restored, RestoreFinishedSubmap(row, {}));
    EXPECT_EQ(restored.T_map_submap, expected.T_map_submap);
    EXPECT_EQ(restored.version, expected.version);
    EXPECT_EQ(restored.content, expected.content);
    EXPECT_EQ(restored.nodes, expected.nodes);
    EXPECT_EQ(restored.next, expected.next);
    EXPECT_EQ(restored.length, expected.length);
    EXPECT_EQ(restored.extent, expected.extent);
    EXPECT_EQ(restored.known.isEmpty(), expected.known.isEmpty());
    EXPECT_TRUE(expected.known.isEmpty() || restored.known.isApprox(expected.known));
  }
}

TEST(RestoreFinishedSubmap, NamesTheRowThatIsDamaged) {
  EXPECT_STATUS(RestoreFinishedSubmap({12, 1, {}, true, "damaged"}, {}), absl::StatusCode::kDataLoss,
                HasSubstr("stored submap 12"));
}

}  // namespace
}  // namespace enfilade::slam
