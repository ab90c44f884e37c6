// SPDX-License-Identifier: Apache-2.0
#include "core/grid/files/grey_image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/grid/files/png_codec.h"
#include "tests/support/status_assertions.h"

namespace enfilade::grid {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::string PngOf(int width, int height, int channels, std::vector<std::uint8_t> samples) {
  return EncodePng(PixelImage{.width = width, .height = height, .channels = channels, .samples = std::move(samples)})
      .value();
}

TEST(GreyImage, WeighsColoursByDialect) {
  struct Row {
    std::vector<std::uint8_t> rgb;
    int nav2;
    int ros1;
  };
  for (const Row& row :
       {Row{{255, 0, 0}, 76, 85}, Row{{0, 255, 0}, 150, 85}, Row{{0, 0, 255}, 29, 85}, Row{{255, 255, 0}, 226, 170},
        Row{{1, 2, 3}, 2, 2}, Row{{0, 0, 1}, 0, 0}, Row{{0, 1, 1}, 1, 1}}) {
    const std::string png = PngOf(1, 1, 3, row.rgb);
    EXPECT_EQ(DecodeGreyPng(png, MapDialect::kNav2)->cells.grey[0], row.nav2);
    EXPECT_EQ(DecodeGreyPng(png, MapDialect::kRos1)->cells.grey[0], row.ros1);
  }
  for (int grey = 0; grey < 256; ++grey) {  // a grey given as RGB stays the same
    const auto level = static_cast<std::uint8_t>(grey);
    const std::string png = PngOf(1, 1, 3, {level, level, level});
    ASSERT_OK_AND_ASSIGN(const GreyImage nav2, DecodeGreyPng(png, MapDialect::kNav2));
    EXPECT_EQ(nav2.cells.grey[0], grey);
    EXPECT_THAT(nav2.warnings, IsEmpty());
    EXPECT_EQ(DecodeGreyPng(png, MapDialect::kRos1)->cells.grey[0], grey);
  }
}

TEST(GreyImage, TurnsTheRowsOver) {
  ASSERT_OK_AND_ASSIGN(const GreyImage image, DecodeGreyPng(PngOf(2, 3, 1, {1, 2, 3, 4, 5, 6}), MapDialect::kNav2));
  EXPECT_EQ(image.width, 2);
  EXPECT_EQ(image.height, 3);
  EXPECT_THAT(image.cells.grey, ElementsAre(5, 6, 3, 4, 1, 2));
  ASSERT_OK_AND_ASSIGN(const std::string png, EncodeGreyPng(image.cells, 2, 3));
  EXPECT_THAT(DecodePng(png)->samples, ElementsAre(1, 2, 3, 4, 5, 6));
}

TEST(GreyImage, KeepsAlphaOnlyIfItMatters) {
  const std::string opaque = PngOf(2, 1, 2, {10, 255, 20, 255});
  EXPECT_THAT(DecodeGreyPng(opaque, MapDialect::kNav2)->cells.alpha, IsEmpty());
  EXPECT_THAT(DecodeGreyPng(opaque, MapDialect::kRos1)->cells.alpha, ElementsAre(255, 255));
  const std::string transparent = PngOf(2, 1, 2, {10, 255, 20, 254});
  EXPECT_THAT(DecodeGreyPng(transparent, MapDialect::kNav2)->cells.alpha, ElementsAre(255, 254));
  const std::string color = PngOf(1, 1, 4, {9, 9, 9, 0});
  EXPECT_THAT(DecodeGreyPng(color, MapDialect::kNav2)->cells.alpha, ElementsAre(0));
}

TEST(GreyImage, ScalesOtherWhitesTo255) {
  for (const int max_value : {1, 7, 15, 100, 254}) {
    GreyCells cells{.grey = {}, .max_value = max_value};
    for (int level = 0; level <= max_value; ++level) cells.grey.push_back(static_cast<std::uint8_t>(level));
    ASSERT_OK_AND_ASSIGN(const std::string png, EncodeGreyPng(cells, max_value + 1, 1));
    ASSERT_OK_AND_ASSIGN(const PixelImage image, DecodePng(png));
    for (int level = 0; level <= max_value; ++level) {
      EXPECT_EQ(image.samples[static_cast<std::size_t>(level)], std::lround(level * 255.0 / max_value)) << max_value;
    }
  }
}

TEST(GreyImage, SavesEveryCellAsItsOccupancyValue) {
  std::vector<std::uint8_t> occupancy(256);
  for (std::size_t cell = 0; cell < 256; ++cell) occupancy[cell] = static_cast<std::uint8_t>(cell);
  for (const MapMode mode : {MapMode::kTrinary, MapMode::kScale, MapMode::kRaw}) {
    const GreySaveOptions options{.mode = mode};
    const GreyCells saved = SaveAsGrey(occupancy, options);
    EXPECT_EQ(saved.interpretation, InterpretationOfSaved(options));
    EXPECT_EQ(saved.alpha.empty(), mode != MapMode::kScale);
    for (std::size_t cell = 0; cell < 256; ++cell) {
      const GreyAlpha expected = SavedGrey(options, OccupancyValueOfCell(occupancy[cell]));
      EXPECT_EQ(saved.grey[cell], expected.grey) << cell;
      if (!saved.alpha.empty()) {
        EXPECT_EQ(saved.alpha[cell], expected.alpha) << cell;
      }
    }
  }
  EXPECT_THAT(SaveAsGrey({1, 255}, {.mode = MapMode::kScale}).alpha, IsEmpty()) << "no cell is unknown";
}

// Savings in every mode, read with their interpretation, agree with the grid as well as the mode can.
TEST(GreyImage, WhatIsSavedReadsAlike) {
  std::mt19937 random(3);
  OccupancyGrid grid;
  grid.geometry = {.resolution = 0.05, .T_map_grid = {}, .width = 50, .height = 20};
  for (int i = 0; i < 1000; ++i) grid.cells.push_back(static_cast<std::uint8_t>(random()));
  for (const MapMode mode : {MapMode::kTrinary, MapMode::kScale, MapMode::kRaw}) {
    const GreyCells saved = SaveAsGrey(grid.cells, {.mode = mode});
    const OccupancyGrid back = ToOccupancyGrid(MapRaster{grid.geometry, saved});
    for (std::size_t i = 0; i < grid.cells.size(); ++i) {
      const std::int8_t before = OccupancyValueOfCell(grid.cells[i]);
      const std::int8_t after = OccupancyValueOfCell(back.cells[i]);
      if (mode == MapMode::kRaw) {
        ASSERT_EQ(after, before);
      } else if (mode == MapMode::kTrinary) {
        ASSERT_EQ(after, before == kUnknownValue ? kUnknownValue
                         : before <= 25          ? 0
                         : before >= 65          ? 100
                                                 : kUnknownValue);
      } else {
        ASSERT_EQ(after == kUnknownValue, before == kUnknownValue);
      }
    }
  }
}

}  // namespace
}  // namespace enfilade::grid
