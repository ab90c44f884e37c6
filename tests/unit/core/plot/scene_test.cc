// SPDX-License-Identifier: Apache-2.0
#include "core/plot/scene.h"

#include <cmath>
#include <numbers>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/support/status_assertions.h"

namespace enfilade::plot {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

grid::Rgb PixelAt(const grid::RgbImage& image, const Eigen::Vector2d& pixel) {
  const std::size_t offset = 3 * (static_cast<std::size_t>(pixel.y()) * static_cast<std::size_t>(image.width) +
                                  static_cast<std::size_t>(pixel.x()));
  return {image.samples[offset], image.samples[offset + 1], image.samples[offset + 2]};
}

// 4 x 2 cells of 1 m, all free but the last of the lower row; the first of the upper row is unknown.
SceneRaster Raster(const Pose2& T_scene_map) {
  SceneRaster raster;
  raster.grid.geometry = {.resolution = 1.0, .T_map_grid = {}, .width = 4, .height = 2};
  raster.grid.cells = {1, 1, 1, 255, 0, 1, 1, 1};
  raster.T_scene_map = T_scene_map;
  raster.color = grid::kBlue;
  return raster;
}

TEST(ViewTest, ShowsEverythingWithTheRequestedLongerSide) {
  Scene scene;
  scene.lines.push_back({{{-10.0, 2.0}, {30.0, 12.0}}, grid::kRed, 1});
  const auto view = ViewOf(scene, 800);
  ASSERT_OK(view);
  EXPECT_EQ(view->width, 800);
  for (const Eigen::Vector2d& p : scene.lines[0].points) {
    const Eigen::Vector2d pixel = view->ToPixel(p);
    EXPECT_GT(pixel.minCoeff(), 0.0);
    EXPECT_LT(pixel.x(), view->width);
    EXPECT_LT(pixel.y(), view->height);
    EXPECT_LT((view->ToScene(pixel) - p).norm(), 1e-9);
  }
  EXPECT_LT(view->ToPixel({0.0, 12.0}).y(), view->ToPixel({0.0, 2.0}).y());
}

TEST(ViewTest, RefusesEmptyScenesAndInfinitePositions) {
  EXPECT_FALSE(ViewOf(Scene(), 800).ok());
  Scene scene;
  scene.markers.push_back({{std::nan(""), 0.0}, SceneMarker::Shape::kDot, grid::kRed});
  EXPECT_FALSE(ViewOf(scene, 800).ok());
  scene.markers[0].at = {0.0, 0.0};
  EXPECT_FALSE(ViewOf(scene, 10).ok());
  EXPECT_TRUE(ViewOf(scene, 800).ok());
}

TEST(OutlineTest, ReachesAsFarAsTheSemiAxesAlongTheirDirections) {
  const SceneEllipse ellipse{{1.0, 2.0}, 3.0, 0.5, std::numbers::pi / 2, grid::kRed};
  const auto outline = Outline(ellipse);
  EXPECT_LT((outline.front() - Eigen::Vector2d(1.0, 5.0)).norm(), 1e-9);
  EXPECT_LT((outline[outline.size() / 4] - Eigen::Vector2d(0.5, 2.0)).norm(), 1e-9);
  EXPECT_EQ(outline.front(), outline.back());
}

TEST(DrawSceneTest, PutsARotatedMapWhereItLies) {
  Scene scene;
  scene.rasters.push_back(Raster({10.0, 5.0, std::numbers::pi / 2}));  // its x axis points up
  const auto view = ViewOf(scene, 400);
  ASSERT_OK(view);
  const grid::RgbImage image = DrawScene(scene, *view);
  const auto at = [&](double x, double y) { return PixelAt(image, view->ToPixel({x, y})); };
  EXPECT_EQ(at(9.5, 8.5), ColorOfCell(255, grid::kBlue));  // cell (3, 0)
  EXPECT_EQ(at(9.5, 5.5), ColorOfCell(1, grid::kBlue));    // cell (0, 0)
  EXPECT_EQ(at(8.5, 8.5), ColorOfCell(1, grid::kBlue));    // cell (3, 1)
  EXPECT_EQ(at(8.5, 5.5), (grid::Rgb{255, 255, 255}));     // cell (0, 1), unknown
  EXPECT_EQ(at(10.2, 8.5), (grid::Rgb{255, 255, 255}));    // beside it
}

TEST(DrawSceneTest, KeepsThinWallsWhenPixelsAreCoarserThanCells) {
  Scene scene;
  SceneRaster raster;
  raster.grid.geometry = {.resolution = 0.05, .T_map_grid = {}, .width = 1000, .height = 1000};
  raster.grid.cells.assign(1'000'000, 1);
  for (int row = 0; row < 1000; ++row) raster.grid.cells[raster.grid.geometry.index(501, row)] = 255;
  raster.color = grid::kRed;
  scene.rasters.push_back(raster);
  const auto view = ViewOf(scene, 100);
  ASSERT_OK(view);
  const grid::RgbImage image = DrawScene(scene, *view);
  for (double y = 1.0; y < 49.0; y += 1.0) {
    EXPECT_EQ(PixelAt(image, view->ToPixel({501.5 * 0.05, y})), ColorOfCell(255, grid::kRed));
  }
}

TEST(WriteSvgTest, EscapesNamesAndEmbedsTheGridTurned) {
  Scene scene;
  scene.rasters.push_back(Raster({10.0, 5.0, std::numbers::pi / 2}));
  scene.labels.push_back({{10.0, 5.0}, "R&D <lab>\x01", grid::kBlue});
  scene.ellipses.push_back({{9.0, 6.0}, 2.0, 1.0, std::numbers::pi / 4, grid::kRed});
  const auto view = ViewOf(scene, 400);
  ASSERT_OK(view);
  const auto svg = WriteSvg(scene, *view);
  ASSERT_OK(svg);
  EXPECT_THAT(*svg, HasSubstr(">R&amp;D &lt;lab&gt; </text>"));
  EXPECT_THAT(*svg, Not(HasSubstr("<lab>")));
  EXPECT_THAT(*svg, HasSubstr("data:image/png;base64,iVBORw0KGgo"));  // PNG's signature
  EXPECT_THAT(*svg, HasSubstr("rotate(-45.0000)"));
  const std::size_t matrix = svg->find("matrix(");
  ASSERT_NE(matrix, std::string::npos);
  double a = 0.0, b = 0.0, c = 0.0, d = 0.0, e = 0.0, f = 0.0;
  ASSERT_EQ(std::sscanf(svg->c_str() + matrix, "matrix(%lf %lf %lf %lf %lf %lf)", &a, &b, &c, &d, &e, &f), 6);
  // The centre of cell (3, 0) is at column 3.5 and row 1.5 of the image.
  const Eigen::Vector2d pixel(a * 3.5 + c * 1.5 + e, b * 3.5 + d * 1.5 + f);
  EXPECT_LT((view->ToScene(pixel) - Eigen::Vector2d(9.5, 8.5)).norm(), 1e-3);
}

}  // namespace
}  // namespace enfilade::plot
