// SPDX-License-Identifier: Apache-2.0
#include "core/grid/files/rgb_image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/grid/files/png_codec.h"
#include "tests/support/status_assertions.h"

namespace enfilade::grid {
namespace {

constexpr Rgb kWhite{255, 255, 255};

bool Has(const RgbImage& image, int column, int row, Rgb color) {
  const std::size_t offset = static_cast<std::size_t>(row * image.width + column) * 3;
  return image.samples[offset] == color[0] && image.samples[offset + 1] == color[1] &&
         image.samples[offset + 2] == color[2];
}

std::string Draw(const RgbImage& image, Rgb color) {
  std::string text;
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) text += Has(image, column, row, color) ? '#' : '.';
    text += '\n';
  }
  return text;
}

TEST(RgbImage, DrawsTheGridWithItsHighestRowOnTop) {
  OccupancyGrid grid{{.resolution = 1.0, .T_map_grid = {}, .width = 2, .height = 2}, {1, 255, kUnknownCell, 128}};
  const RgbImage image = DrawGrid(grid);
  EXPECT_TRUE(Has(image, 0, 1, {254, 254, 254}));
  EXPECT_TRUE(Has(image, 1, 1, {0, 0, 0}));
  EXPECT_TRUE(Has(image, 1, 0, {127, 127, 127}));
  EXPECT_NE(image.samples[0], image.samples[2]);  // unknown is tinted
}

TEST(RgbImage, DrawsThinAndThickLines) {
  RgbImage thin(5, 3, kWhite);
  DrawLine(thin, {0, 0}, {4, 2}, kRed);
  EXPECT_EQ(Draw(thin, kRed), "#....\n.##..\n...##\n");
  RgbImage thick(5, 5, kWhite);
  DrawLine(thick, {1, 2}, {3, 2}, kRed, 3);
  EXPECT_EQ(Draw(thick, kRed), ".....\n#####\n#####\n#####\n.....\n");
}

TEST(RgbImage, CutsLinesThatLeaveTheImage) {
  RgbImage image(4, 3, kWhite);
  DrawLine(image, {-1e12, 1}, {1e12, 1}, kRed);
  EXPECT_EQ(Draw(image, kRed), "....\n####\n....\n");
  DrawLine(image, {-1e12, -50}, {1e12, -50}, kRed);
  DrawLine(image, {0, 0}, {std::numeric_limits<double>::quiet_NaN(), 0}, kRed);
  DrawLine(image, {0, 0}, {std::numeric_limits<double>::infinity(), 0}, kRed);
  EXPECT_EQ(Draw(image, kRed), "....\n####\n....\n");
}

TEST(RgbImage, DrawsPathsInTheMapsFrame) {
  const GridGeometry geometry{.resolution = 0.5, .T_map_grid = {1.0, 2.0, 0.0}, .width = 4, .height = 3};
  RgbImage image(4, 3, kWhite);
  DrawPath(image, geometry, std::vector<Eigen::Vector2d>{{1.25, 2.25}, {2.75, 2.25}, {2.75, 3.25}}, kBlue);
  EXPECT_EQ(Draw(image, kBlue), "...#\n...#\n####\n");
}

TEST(RgbImage, TurnsPathsWithTheGrid) {
  const GridGeometry geometry{.resolution = 1.0, .T_map_grid = {10.0, 0.0, M_PI / 2.0}, .width = 3, .height = 2};
  EXPECT_TRUE(PixelOf(geometry, {9.5, 0.5}).isApprox(Eigen::Vector2d(0.0, 1.0), 1e-9));
  EXPECT_TRUE(PixelOf(geometry, {8.5, 2.5}).isApprox(Eigen::Vector2d(2.0, 0.0), 1e-9));
}

TEST(RgbImage, BecomesAPng) {
  RgbImage image(3, 2, kGreen);
  DrawLine(image, {0, 0}, {2, 0}, kRed);
  ASSERT_OK_AND_ASSIGN(const std::string png, EncodePng(image));
  ASSERT_OK_AND_ASSIGN(const PixelImage decoded, DecodePng(png));
  EXPECT_EQ(decoded.channels, 3);
  EXPECT_EQ(decoded.samples, image.samples);
}

}  // namespace
}  // namespace enfilade::grid
