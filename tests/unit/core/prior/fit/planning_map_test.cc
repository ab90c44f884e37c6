// SPDX-License-Identifier: Apache-2.0
#include "core/prior/fit/planning_map.h"

#include <gtest/gtest.h>

#include "core/prior/plan/planar.h"
#include "tests/support/plans/drawn_building.h"

namespace enfilade::prior {
namespace {

const PlanTransform kPlace{Eigen::Vector2d(0.05, -0.05).asDiagonal(), {1.0, 30.0}};

// Robots have been in all but the right third; the drawing is right.
class PlanningMapTest : public ::testing::Test {
 protected:
  PlanningMapTest() {
    plan_ = Planarise(DrawnBuilding(), 1.0);
    plan_.doors = {{{2 * 20, 200}, {3 * 20, 200}}, {{30 * 20, 200}, {31 * 20, 200}}};
    plan_.rooms = {{.outline = {{680, 0}, {880, 0}, {880, 320}, {680, 320}}, .name = "hall"}};
    seen_ = MapOf(plan_, kPlace, [](const Eigen::Vector2d& sheet) { return sheet.x() < 600; });
    evidence_ = EvidenceOf(seen_);
    corrected_ = std::make_unique<CorrectedPlan>(plan_, evidence_, kPlace);
  }
  std::size_t CellAt(const PlanningMap& planning, const Eigen::Vector2d& sheet) const {
    const grid::GridGeometry& geometry = planning.map.geometry;
    const Eigen::Vector2d cell = (Inverse(geometry.T_map_grid) * kPlace(sheet)) / geometry.resolution;
    return geometry.index(static_cast<int>(cell.x()), static_cast<int>(cell.y()));
  }

  PlanGraph plan_;
  grid::OccupancyGrid seen_;
  MapEvidence evidence_;
  std::unique_ptr<CorrectedPlan> corrected_;
};

TEST_F(PlanningMapTest, WhatRobotsHaveSeenStaysByteByByte) {
  const auto planning = MakePlanningMap(seen_, evidence_, plan_, *corrected_);
  ASSERT_TRUE(planning.ok()) << planning.status();
  const grid::GridGeometry& geometry = planning->map.geometry;
  const Eigen::Vector2d shift =
      (Inverse(geometry.T_map_grid) * seen_.geometry.T_map_grid).translation() / geometry.resolution;
  const int columns = static_cast<int>(std::lround(shift.x()));
  const int rows = static_cast<int>(std::lround(shift.y()));
  EXPECT_NEAR(shift.x(), columns, 1e-6) << "whole cells";
  EXPECT_NEAR(shift.y(), rows, 1e-6);
  std::size_t seen = 0;
  for (int row = 0; row < seen_.geometry.height; ++row) {
    for (int column = 0; column < seen_.geometry.width; ++column) {
      const std::uint8_t before = seen_.cells[seen_.geometry.index(column, row)];
      const std::size_t after = geometry.index(column + columns, row + rows);
      if (before == grid::kUnknownCell) {
        EXPECT_NE(planning->sources[after], CellSource::kSeen);
        continue;
      }
      ++seen;
      ASSERT_EQ(planning->map.cells[after], before);
      ASSERT_EQ(planning->sources[after], CellSource::kSeen);
    }
  }
  EXPECT_EQ(std::count(planning->sources.begin(), planning->sources.end(), CellSource::kSeen),
            static_cast<std::ptrdiff_t>(seen));
  for (std::size_t i = 0; i < planning->sources.size(); ++i) {
    ASSERT_EQ(planning->sources[i] == CellSource::kUnknown, planning->map.cells[i] == grid::kUnknownCell);
  }
}

TEST_F(PlanningMapTest, ThePlanFillsTheRest) {
  const auto planning = MakePlanningMap(seen_, evidence_, plan_, *corrected_);
  ASSERT_TRUE(planning.ok()) << planning.status();
  const std::size_t hall = CellAt(*planning, {780, 160});
  EXPECT_EQ(planning->sources[hall], CellSource::kPredicted);
  EXPECT_LT(grid::ProbabilityOfCell(planning->map.cells[hall]), 0.2);
  const std::size_t wall = CellAt(*planning, {880, 160});
  EXPECT_EQ(planning->sources[wall], CellSource::kPredicted);
  EXPECT_GT(grid::ProbabilityOfCell(planning->map.cells[wall]), 0.8);
  // In no room, and on no wall.
  EXPECT_EQ(planning->sources[CellAt(*planning, {780, 440})], CellSource::kUnknown);
}

TEST_F(PlanningMapTest, WallsThatAreNotThereAreLeftOut) {
  PlanGraph wrong = plan_;
  const int first = static_cast<int>(wrong.corners.size());
  wrong.corners.push_back({{30, 60}});
  wrong.corners.push_back({{30, 140}});  // across a room that robots have been in
  wrong.walls.push_back({.from = first, .to = first + 1});
  const CorrectedPlan corrected(wrong, evidence_, kPlace);
  ASSERT_EQ(corrected.walls().back().sight, Sight::kContradicted);
  // Even where nobody has seen the place: here half of the map is forgotten.
  grid::OccupancyGrid forgotten = seen_;
  std::fill(forgotten.cells.begin(), forgotten.cells.end(), grid::kUnknownCell);
  const auto planning = MakePlanningMap(forgotten, evidence_, wrong, corrected);
  ASSERT_TRUE(planning.ok()) << planning.status();
  EXPECT_EQ(planning->sources[CellAt(*planning, {30, 100})], CellSource::kUnknown);
}

TEST_F(PlanningMapTest, TheCorrectedGraphIsInMetresOfTheMap) {
  const PlanGraph graph = CorrectedGraph(plan_, *corrected_);
  ASSERT_EQ(graph.corners.size(), plan_.corners.size());
  EXPECT_TRUE(Validate(graph).ok());
  for (std::size_t i = 0; i < graph.corners.size(); ++i) {
    const Eigen::Vector2d true_point = kPlace(plan_.corners[i].point);
    EXPECT_NEAR(graph.corners[i].point.x(), true_point.x(), 0.3);
    EXPECT_NEAR(-graph.corners[i].point.y(), true_point.y(), 0.3);
  }
  EXPECT_NEAR((graph.doors[0].to - graph.doors[0].from).norm(), 1.0, 0.1);
}

}  // namespace
}  // namespace enfilade::prior
