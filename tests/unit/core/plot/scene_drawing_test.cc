// SPDX-License-Identifier: Apache-2.0
// Each element of a scene, drawn as pixels and as SVG.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "core/grid/files/png_codec.h"
#include "core/plot/scene.h"
#include "tests/support/status_assertions.h"

namespace enfilade::plot {
namespace {

using ::testing::HasSubstr;

// 10 m x 10 m around the origin, 40 pixels per metre.
SceneView SquareView() { return {.upper_left = {-5.0, 5.0}, .px_per_m = 40.0, .width = 400, .height = 400}; }

grid::Rgb ColorAt(const grid::RgbImage& image, const SceneView& view, const Eigen::Vector2d& p) {
  const Eigen::Vector2d pixel = view.ToPixel(p);
  const std::size_t offset = 3 * (static_cast<std::size_t>(pixel.y()) * static_cast<std::size_t>(image.width) +
                                  static_cast<std::size_t>(pixel.x()));
  return {image.samples[offset], image.samples[offset + 1], image.samples[offset + 2]};
}

constexpr grid::Rgb kBlank{255, 255, 255};

TEST(SceneView, MapsBothWays) {
  const SceneView view = SquareView();
  EXPECT_EQ(view.ToPixel({0, 0}), Eigen::Vector2d(200, 200));
  EXPECT_EQ(view.ToPixel({0, 1}), Eigen::Vector2d(200, 160)) << "y points up in the scene and down in the picture";
  std::mt19937 random(1);
  std::uniform_real_distribution<double> coordinate(-100.0, 100.0);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2d p(coordinate(random), coordinate(random));
    EXPECT_LT((view.ToScene(view.ToPixel(p)) - p).norm(), 1e-9);
  }
}

TEST(ViewOfTest, ShowsEveryKindOfElement) {
  std::vector<Scene> scenes(5);
  scenes[0].rasters.push_back({{{.resolution = 1.0, .T_map_grid = {2, 3, 0}, .width = 4, .height = 5}, {}}, {}, {}});
  scenes[0].rasters[0].grid.cells.assign(20, 1);
  scenes[1].lines.push_back({{{2, 3}, {6, 8}}, grid::kRed, 1});
  scenes[2].ellipses.push_back({{4, 5}, 2.0, 1.0, 0.0, grid::kRed});
  scenes[3].markers.push_back({{4, 5}, SceneMarker::Shape::kDot, grid::kRed});
  scenes[4].labels.push_back({{4, 5}, "text", grid::kRed});
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    ASSERT_OK_AND_ASSIGN(const SceneView view, ViewOf(scenes[i], 200));
    EXPECT_EQ(std::max(view.width, view.height), 200) << i;
    const Eigen::Vector2d center = view.ToPixel({4, 5});
    EXPECT_GT(center.minCoeff(), 0.0) << i;
    EXPECT_LT(center.x(), view.width) << i;
    EXPECT_LT(center.y(), view.height) << i;
  }
}

TEST(ViewOfTest, LimitsTheSize) {
  Scene scene;
  scene.markers.push_back({{0, 0}, SceneMarker::Shape::kDot, grid::kRed});
  EXPECT_OK(ViewOf(scene, 64));
  EXPECT_STATUS(ViewOf(scene, 63), absl::StatusCode::kInvalidArgument, HasSubstr("64 to 16384"));
  EXPECT_STATUS(ViewOf(scene, 16385), absl::StatusCode::kInvalidArgument, HasSubstr("64 to 16384"));
  EXPECT_STATUS(ViewOf(Scene(), 800), absl::StatusCode::kInvalidArgument, HasSubstr("empty"));
  scene.lines.push_back({{{0, 0}, {INFINITY, 0}}, grid::kRed, 1});
  EXPECT_STATUS(ViewOf(scene, 800), absl::StatusCode::kInvalidArgument, HasSubstr("not finite"));
}

TEST(DrawElements, MarkersHaveTheirShapes) {
  const SceneView view = SquareView();
  Scene scene;
  scene.markers = {{{-3, 0}, SceneMarker::Shape::kDot, grid::kRed},
                   {{0, 0}, SceneMarker::Shape::kRing, grid::kGreen},
                   {{3, 0}, SceneMarker::Shape::kCross, grid::kBlue},
                   {{0, 3}, SceneMarker::Shape::kSquare, grid::kRed}};
  const grid::RgbImage image = DrawScene(scene, view);
  EXPECT_EQ(ColorAt(image, view, {-3, 0}), grid::kRed);
  EXPECT_EQ(ColorAt(image, view, {0, 0}), kBlank) << "a ring is hollow";
  EXPECT_EQ(ColorAt(image, view, {0, 0.1}), grid::kGreen);
  EXPECT_EQ(ColorAt(image, view, {3, 0}), grid::kBlue);
  EXPECT_EQ(ColorAt(image, view, {3.1, 0.1}), grid::kBlue);
  EXPECT_EQ(ColorAt(image, view, {3.1, 0.0}), kBlank);
  EXPECT_EQ(ColorAt(image, view, {-1.5, 0}), kBlank);
  EXPECT_EQ(ColorAt(image, view, {0.09, 3.09}), grid::kRed) << "a square has corners";
}

TEST(DrawElements, LinesAndEllipsesFollowTheirPoints) {
  const SceneView view = SquareView();
  Scene scene;
  scene.lines.push_back({{{-4, -4}, {4, -4}, {4, 4}}, grid::kRed, 3});
  scene.ellipses.push_back({{0, 0}, 3.0, 1.0, std::numbers::pi / 2, grid::kBlue});
  const grid::RgbImage image = DrawScene(scene, view);
  for (double t = -3.9; t < 4.0; t += 0.3) {
    EXPECT_EQ(ColorAt(image, view, {t, -4}), grid::kRed);
    EXPECT_EQ(ColorAt(image, view, {4, t}), grid::kRed);
  }
  EXPECT_EQ(ColorAt(image, view, {0, 3}), grid::kBlue);
  EXPECT_EQ(ColorAt(image, view, {-1, 0}), grid::kBlue);
  EXPECT_EQ(ColorAt(image, view, {3, 0}), kBlank) << "the larger axis points up";
  EXPECT_EQ(ColorAt(image, view, {0, 0}), kBlank);
}

TEST(DrawElements, LaterElementsCoverEarlierOnes) {
  const SceneView view = SquareView();
  Scene scene;
  scene.lines.push_back({{{-2, 0}, {2, 0}}, grid::kRed, 3});
  scene.lines.push_back({{{0, -2}, {0, 2}}, grid::kBlue, 3});
  EXPECT_EQ(ColorAt(DrawScene(scene, view), view, {0, 0}), grid::kBlue);
  std::swap(scene.lines[0], scene.lines[1]);
  EXPECT_EQ(ColorAt(DrawScene(scene, view), view, {0, 0}), grid::kRed);
}

TEST(DrawElements, OverlappingMapsBothStayVisible) {
  const SceneView view = SquareView();
  Scene scene;
  SceneRaster raster;
  raster.grid.geometry = {.resolution = 1.0, .T_map_grid = {}, .width = 2, .height = 2};
  raster.grid.cells = {255, 1, grid::kUnknownCell, 255};
  raster.color = grid::kRed;
  scene.rasters = {raster, raster};
  scene.rasters[1].color = grid::kBlue;
  const grid::RgbImage image = DrawScene(scene, view);
  const grid::Rgb red = ColorOfCell(255, grid::kRed);
  const grid::Rgb blue = ColorOfCell(255, grid::kBlue);
  const grid::Rgb both = ColorAt(image, view, {0.5, 0.5});
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(int{both[i]}, 255 * red[i] / 255 * blue[i] / 255) << i;
  EXPECT_EQ(ColorAt(image, view, {0.5, 1.5}), kBlank) << "unknown in both";
}

TEST(ColorOfCellTest, DarkensWithOccupancy) {
  for (const grid::Rgb color : {grid::kRed, grid::kBlue, grid::kGreen}) {
    grid::Rgb last = ColorOfCell(1, color);
    for (int cell = 2; cell < 256; ++cell) {
      const grid::Rgb next = ColorOfCell(static_cast<std::uint8_t>(cell), color);
      for (std::size_t i = 0; i < 3; ++i) EXPECT_LE(next[i], last[i]) << cell;
      last = next;
    }
  }
}

std::string FromBase64(std::string_view text) {
  std::string bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    const std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    bits = bits << 6U | static_cast<std::uint32_t>(digits.find(c));
    count += 6;
    if (count >= 8) {
      count -= 8;
      bytes += static_cast<char>(bits >> static_cast<unsigned>(count) & 255U);
    }
  }
  return bytes;
}

TEST(WriteSvgElements, EmbedsEachGridAsPngWithTransparentUnknownCells) {
  // Sizes that need every kind of padding in base64.
  for (int width = 1; width <= 6; ++width) {
    Scene scene;
    SceneRaster raster;
    raster.grid.geometry = {.resolution = 0.5, .T_map_grid = {}, .width = width, .height = 2};
    for (int i = 0; i < 2 * width; ++i) raster.grid.cells.push_back(static_cast<std::uint8_t>(i * 17));
    raster.color = grid::kGreen;
    scene.rasters.push_back(raster);
    ASSERT_OK_AND_ASSIGN(const SceneView view, ViewOf(scene, 100));
    ASSERT_OK_AND_ASSIGN(const std::string svg, WriteSvg(scene, view));
    const std::string_view mark = "data:image/png;base64,";
    const std::size_t begin = svg.find(mark) + mark.size();
    const std::string_view encoded = std::string_view(svg).substr(begin, svg.find('"', begin) - begin);
    EXPECT_EQ(encoded.size() % 4, 0U);
    ASSERT_OK_AND_ASSIGN(const grid::PixelImage image, grid::DecodePng(FromBase64(encoded)));
    ASSERT_EQ(image.width, width);
    ASSERT_EQ(image.height, 2);
    ASSERT_EQ(image.channels, 4);
    for (int row = 0; row < 2; ++row) {
      for (int column = 0; column < width; ++column) {
        const std::uint8_t cell = raster.grid.cells[raster.grid.geometry.index(column, row)];
        const std::size_t at = 4 * static_cast<std::size_t>((1 - row) * width + column);
        EXPECT_EQ(image.samples[at + 3], cell == grid::kUnknownCell ? 0 : 255);
        if (cell != grid::kUnknownCell) {
          EXPECT_EQ(image.samples[at], ColorOfCell(cell, grid::kGreen)[0]);
        }
      }
    }
  }
}

TEST(WriteSvgElements, WritesEveryElementInOrder) {
  Scene scene;
  scene.lines.push_back({{{0, 0}, {1, 1}}, grid::kRed, 2});
  scene.ellipses.push_back({{0, 0}, 1.0, 0.5, 0.0, grid::kBlue});
  scene.markers = {{{0, 0}, SceneMarker::Shape::kDot, grid::kRed},
                   {{1, 0}, SceneMarker::Shape::kRing, grid::kGreen},
                   {{2, 0}, SceneMarker::Shape::kCross, grid::kBlue}};
  scene.labels.push_back({{0, 0}, "a > b & \"c\"\n", grid::kRed});
  ASSERT_OK_AND_ASSIGN(const std::string svg, WriteSvg(scene, SquareView()));
  std::size_t last = 0;
  for (const char* element : {"<svg ", "<rect ", "<polyline ", "<ellipse ", "fill=\"#d62728\"",
                              "fill=\"white\"/>\n<path", "<text ", "</svg>"}) {
    const std::size_t at = svg.find(element, last);
    ASSERT_NE(at, std::string::npos) << element;
    last = at;
  }
  EXPECT_THAT(svg, HasSubstr("points=\"200.00,200.00 240.00,160.00\""));
  EXPECT_THAT(svg, HasSubstr("a &gt; b &amp; \"c\" <"));
  EXPECT_THAT(svg, HasSubstr("stroke-width=\"2\""));
}

}  // namespace
}  // namespace enfilade::plot
