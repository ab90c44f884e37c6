// SPDX-License-Identifier: Apache-2.0
#include "core/prior/alignment/wall_faces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/grid/occupancy_grid.h"
#include "core/prior/alignment/map_evidence.h"
#include "core/prior/alignment/plan_transform.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {
namespace {

// A wall 0.3 m thick along x, and free ground on one side of it.
TEST(WallFacesTest, AWallIsComparedWithTheFaceThatLooksAtTheFreeGround) {
  grid::OccupancyGrid map;
  map.geometry = {0.05, {}, 100, 60};
  map.cells.assign(map.geometry.cell_count(), grid::kUnknownCell);
  for (int column = 0; column < 100; ++column) {
    for (int row = 20; row < 40; ++row) {
      map.cells[map.geometry.index(column, row)] = grid::CellFromProbability(row < 39 ? 0.05 : 0.95);
    }
  }
  const MapEvidence evidence = EvidenceOf(map);
  const auto wall = std::find_if(evidence.walls.begin(), evidence.walls.end(),
                                 [](const WallPoint& one) { return std::abs(one.point.x() - 2.5) < 0.2; });
  ASSERT_NE(wall, evidence.walls.end());
  EXPECT_NEAR(wall->open.y(), -1.0, 0.05);
  PlanGraph plan;
  plan.corners = {{{0, 0}}, {{100, 0}}};
  plan.walls = {{.from = 0, .to = 1, .thickness = 6}};  // 0.3 m
  // The lower face, which the robot has seen, lies 0.2 m too low, and so the upper one is the nearer.
  const PlanTransform place{Eigen::Vector2d(0.05, -0.05).asDiagonal(), {0, 1.975 - 0.2 + 0.15}};
  const FaceIndex index(Transformed(FacesOf(plan), place), 1.0);
  const auto nearest = index.Nearest(wall->point, wall->along, kParallel);
  const auto looking = index.Nearest(wall->point, wall->along, kParallel, wall->open);
  ASSERT_TRUE(nearest && looking);
  EXPECT_GT(nearest->point.y(), place.offset.y());
  EXPECT_LT(looking->point.y(), place.offset.y());
}

TEST(FaceIndexTest, FindsTheFaceThatIsNearest) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(0, 30);
  for (const double reach : {0.5, 3.0, 7.5}) {
    std::vector<WallFace> faces;
    for (int i = 0; i < 60; ++i) {
      const Eigen::Vector2d from(place(random), place(random));
      // Some along the axes, some of no length, some sloping.
      const Eigen::Vector2d to(i % 3 == 0 ? from.x() : place(random), i % 4 == 0 ? from.y() : place(random));
      faces.push_back({from, to, i, Eigen::Vector2d::Zero()});
    }
    const FaceIndex index(faces, reach);
    for (int n = 0; n < 2000; ++n) {
      const Eigen::Vector2d point(1.2 * place(random) - 3, 1.2 * place(random) - 3);
      double nearest = reach;
      for (const WallFace& face : faces) {
        const Eigen::Vector2d way = face.to - face.from;
        const double fraction =
            way.squaredNorm() > 0 ? std::clamp((point - face.from).dot(way) / way.squaredNorm(), 0.0, 1.0) : 0.0;
        nearest = std::min(nearest, (face.from + fraction * way - point).norm());
      }
      const auto found = index.Nearest(point, Eigen::Vector2d::Zero(), 0);
      ASSERT_EQ(found.has_value(), nearest < reach) << point.transpose();
      ASSERT_NEAR(found ? found->distance : nearest, nearest, 1e-12) << point.transpose();
    }
  }
}

TEST(FaceIndexTest, HoldsWallsWhereverTheyAre) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double far : {1e5, 1e12, 1e300, std::numeric_limits<double>::infinity(), nan}) {
    const FaceIndex index({{{0, 0}, {1, 0}}, {{-far, 3}, {far, 3}}}, 1.0);
    index.Nearest({0.5, 0.1}, {1, 0}, 1.0);  // that it ends is enough
  }
}

}  // namespace
}  // namespace enfilade::prior
