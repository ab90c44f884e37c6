// SPDX-License-Identifier: Apache-2.0
// Drawn lines and grids against their geometry.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/grid/files/rgb_image.h"

namespace enfilade::grid {
namespace {

constexpr Rgb kPaper{255, 255, 255};

bool IsDrawn(const RgbImage& image, int column, int row) {
  return image.samples[3 * static_cast<std::size_t>(row * image.width + column)] != 255;
}

double DistanceToSegment(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double length = along.squaredNorm();
  const double t = length > 0.0 ? std::clamp((p - a).dot(along) / length, 0.0, 1.0) : 0.0;
  return (p - a - t * along).norm();
}

TEST(DrawLineProperties, CoversTheSegmentAndNothingElse) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> inside(0.0, 39.0);
  std::uniform_real_distribution<double> anywhere(-100.0, 140.0);
  for (int trial = 0; trial < 200; ++trial) {
    auto& coordinate = trial % 2 == 0 ? inside : anywhere;
    const Eigen::Vector2d from(coordinate(random), coordinate(random));
    const Eigen::Vector2d to(coordinate(random), coordinate(random));
    RgbImage image(40, 40, kPaper);
    DrawLine(image, from, to, kBlue);
    for (int row = 0; row < 40; ++row) {
      for (int column = 0; column < 40; ++column) {
        const double distance = DistanceToSegment({column, row}, from, to);
        if (IsDrawn(image, column, row)) {
          ASSERT_LT(distance, 1.3) << trial << ": " << column << ", " << row;
        }
        // A pixel that the segment crosses close to its centre is drawn.
        if (distance < 0.05 && DistanceToSegment({column, row}, from, from) > 1.0 &&
            DistanceToSegment({column, row}, to, to) > 1.0) {
          bool near = false;
          for (int dy = -1; dy <= 1; ++dy) {
            for (int dx = -1; dx <= 1; ++dx) {
              const int c = std::clamp(column + dx, 0, 39);
              const int r = std::clamp(row + dy, 0, 39);
              near = near || IsDrawn(image, c, r);
            }
          }
          ASSERT_TRUE(near) << trial << ": " << column << ", " << row;
        }
      }
    }
  }
}

TEST(DrawLineProperties, DrawsTheSameBothWays) {
  std::mt19937 random(2);
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Vector2d from(static_cast<double>(random() % 30), static_cast<double>(random() % 30));
    const Eigen::Vector2d to(static_cast<double>(random() % 30), static_cast<double>(random() % 30));
    const int thickness = 1 + static_cast<int>(random() % 4);
    RgbImage there(30, 30, kPaper);
    RgbImage back(30, 30, kPaper);
    DrawLine(there, from, to, kRed, thickness);
    DrawLine(back, to, from, kRed, thickness);
    EXPECT_EQ(there.samples, back.samples) << trial;
  }
}

TEST(PixelOfProperties, IsThePixelThatDrawGridGivesACell) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int trial = 0; trial < 50; ++trial) {
    OccupancyGrid grid;
    grid.geometry = {.resolution = 0.05 + 0.2 * std::abs(unit(random)),
                     .T_map_grid = {10.0 * unit(random), 10.0 * unit(random), M_PI * unit(random)},
                     .width = 1 + static_cast<int>(random() % 20),
                     .height = 1 + static_cast<int>(random() % 20)};
    grid.cells.assign(grid.geometry.cell_count(), 1);
    const int column = static_cast<int>(random() % static_cast<unsigned>(grid.geometry.width));
    const int row = static_cast<int>(random() % static_cast<unsigned>(grid.geometry.height));
    grid.cells[grid.geometry.index(column, row)] = 255;
    const RgbImage image = DrawGrid(grid);
    const Eigen::Vector2d centre = grid.geometry.T_map_grid * Eigen::Vector2d((column + 0.5) * grid.geometry.resolution,
                                                                              (row + 0.5) * grid.geometry.resolution);
    const Eigen::Vector2d pixel = PixelOf(grid.geometry, centre);
    EXPECT_NEAR(pixel.x(), column, 1e-9);
    EXPECT_NEAR(pixel.y(), grid.geometry.height - 1 - row, 1e-9);
    const auto at = 3 * static_cast<std::size_t>(std::lround(pixel.y()) * image.width + std::lround(pixel.x()));
    EXPECT_EQ(image.samples[at], 0) << "the occupied cell is black";
    EXPECT_EQ(std::count(image.samples.begin(), image.samples.end(), 0), 3);
  }
}

}  // namespace
}  // namespace enfilade::grid
