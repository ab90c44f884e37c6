// SPDX-License-Identifier: Apache-2.0
#include "core/grid/occupancy_values.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ostream>
#include <string>

#include "tests/support/status_assertions.h"

namespace enfilade::grid {

void PrintTo(const GreyAlpha& pixel, std::ostream* os) { *os << int{pixel.grey} << "/" << int{pixel.alpha}; }

namespace {

using ::testing::HasSubstr;

GreyInterpretation Reading(MapMode mode, double occupied_thresh, double free_thresh) {
  return {.mode = mode, .occupied_thresh = occupied_thresh, .free_thresh = free_thresh};
}

// Computed in single precision from Nav2's rules, negate 0.
struct GoldenVector {
  int grey;
  int trinary_196;  // 0.65 / 0.196
  int trinary_250;  // 0.65 / 0.25
  int scale_250;
  int scale_196;
  int raw;
};

void PrintTo(const GoldenVector& vector, std::ostream* os) { *os << "grey " << vector.grey; }

class Nav2Load : public ::testing::TestWithParam<GoldenVector> {};

INSTANTIATE_TEST_SUITE_P(GoldenVectors, Nav2Load,
                         ::testing::Values(GoldenVector{0, 100, 100, 100, 100, 0},  //
                                           GoldenVector{50, 100, 100, 100, 100, 50},
                                           GoldenVector{89, 100, 100, 100, 100, 89},
                                           GoldenVector{90, -1, -1, 99, 99, 90}, GoldenVector{100, -1, -1, 89, 91, 100},
                                           GoldenVector{127, -1, -1, 63, 67, -1}, GoldenVector{128, -1, -1, 62, 67, -1},
                                           GoldenVector{191, -1, -1, 0, 12, -1}, GoldenVector{192, -1, 0, 0, 11, -1},
                                           GoldenVector{205, -1, 0, 0, 0, -1},  // 0.65 / 0.25: unknown turns free
                                           GoldenVector{206, 0, 0, 0, 0, -1},   //
                                           GoldenVector{254, 0, 0, 0, 0, -1},   //
                                           GoldenVector{255, 0, 0, 0, 0, -1}));

TEST_P(Nav2Load, ReadsTheGoldenVector) {
  const GoldenVector& expected = GetParam();
  EXPECT_EQ(LoadedValue(Reading(MapMode::kTrinary, 0.65, 0.196), expected.grey), expected.trinary_196);
  EXPECT_EQ(LoadedValue(Reading(MapMode::kTrinary, 0.65, 0.25), expected.grey), expected.trinary_250);
  EXPECT_EQ(LoadedValue(Reading(MapMode::kScale, 0.65, 0.25), expected.grey), expected.scale_250);
  EXPECT_EQ(LoadedValue(Reading(MapMode::kScale, 0.65, 0.196), expected.grey), expected.scale_196);
  EXPECT_EQ(LoadedValue(Reading(MapMode::kRaw, 0.65, 0.196), expected.grey), expected.raw);
}

TEST_P(Nav2Load, ReadsTheNegativeOfItWithNegate) {
  const GoldenVector& expected = GetParam();
  GreyInterpretation negated = Reading(MapMode::kTrinary, 0.65, 0.196);
  negated.negate = true;
  EXPECT_EQ(LoadedValue(negated, 255 - expected.grey), expected.trinary_196);
  negated.mode = MapMode::kRaw;
  EXPECT_EQ(LoadedValue(negated, expected.grey), expected.raw) << "raw ignores negate";
}

TEST(Nav2Load, TreatsTransparentPixelsAsUnknown) {
  for (const MapMode mode : {MapMode::kTrinary, MapMode::kScale}) {
    const GreyInterpretation reading = Reading(mode, 0.65, 0.196);
    EXPECT_EQ(LoadedValue(reading, 0, 254), -1);
    EXPECT_EQ(LoadedValue(reading, 0, 255), 100);
  }
  EXPECT_EQ(LoadedValue(Reading(MapMode::kRaw, 0.65, 0.196), 42, 0), 42);
}

TEST(Nav2Load, LetsFreeWinWhereThresholdsCross) {
  EXPECT_EQ(LoadedValue(Reading(MapMode::kTrinary, 0.3, 0.7), 128), 0);
}

TEST(Nav2Load, IncludesTheThresholds) {
  // p = 1 - 0 / 255 = 1 and 1 - 255 / 255 = 0 exactly.
  EXPECT_EQ(LoadedValue(Reading(MapMode::kTrinary, 1.0, 0.0), 0), 100);
  EXPECT_EQ(LoadedValue(Reading(MapMode::kTrinary, 1.0, 0.0), 255), 0);
}

GreyInterpretation Ros1(MapMode mode, double occupied_thresh, double free_thresh) {
  GreyInterpretation reading = Reading(mode, occupied_thresh, free_thresh);
  reading.dialect = MapDialect::kRos1;
  return reading;
}

TEST(Ros1Load, ExcludesTheThresholds) {
  EXPECT_EQ(LoadedValue(Ros1(MapMode::kTrinary, 1.0, 0.0), 0), -1);
  EXPECT_EQ(LoadedValue(Ros1(MapMode::kTrinary, 1.0, 0.0), 255), -1);
  EXPECT_EQ(LoadedValue(Ros1(MapMode::kTrinary, 0.65, 0.196), 0), 100);
  EXPECT_EQ(LoadedValue(Ros1(MapMode::kTrinary, 0.65, 0.196), 205), -1);
  EXPECT_EQ(LoadedValue(Ros1(MapMode::kTrinary, 0.65, 0.196), 254), 0);
}

TEST(Ros1Load, ScalesFrom1To99) {
  const GreyInterpretation reading = Ros1(MapMode::kScale, 1.0, 0.0);
  EXPECT_EQ(LoadedValue(reading, 0), 99);
  EXPECT_EQ(LoadedValue(reading, 255), 1);
  EXPECT_EQ(LoadedValue(reading, 51), 79);  // 1 + 98 * 0.8 = 79.4
  EXPECT_EQ(LoadedValue(reading, 51, 0), -1);
  EXPECT_EQ(LoadedValue(reading, 51, 1), 79);
}

TEST(Ros1Load, AveragesAlphaIntoTheColourInTrinary) {
  // Black but see-through: (3 * 0 + 255) / 4 = 63.75 -> p = 0.75; white and gone: 191.25 -> p = 0.25.
  EXPECT_EQ(LoadedValue(Ros1(MapMode::kTrinary, 0.65, 0.196), 0, 255), 100);
  EXPECT_EQ(LoadedValue(Ros1(MapMode::kTrinary, 0.8, 0.196), 0, 255), -1);
  EXPECT_EQ(LoadedValue(Ros1(MapMode::kTrinary, 0.65, 0.196), 255, 0), -1);
}

TEST(Ros1Load, NegatesRaw) {
  GreyInterpretation reading = Ros1(MapMode::kRaw, 0.65, 0.196);
  EXPECT_EQ(LoadedValue(reading, 100), 100);
  EXPECT_EQ(LoadedValue(reading, 101), -1);
  reading.negate = true;
  EXPECT_EQ(LoadedValue(reading, 255), 0);
  EXPECT_EQ(LoadedValue(reading, 0), -1);
}

TEST(LoadedValues, ScalesOtherWhites) {
  const auto values = LoadedValues(Reading(MapMode::kTrinary, 0.65, 0.196), 100);
  EXPECT_EQ(values[0], 100);
  EXPECT_EQ(values[100], 0);
  EXPECT_EQ(values[80], -1);  // 204 of 255
  EXPECT_EQ(values[81], 0);   // 207 (206.55) of 255
  const auto plain = LoadedValues(Reading(MapMode::kRaw, 0.65, 0.196), 255);
  for (int grey = 0; grey < 256; ++grey) EXPECT_EQ(plain[static_cast<std::size_t>(grey)], grey <= 100 ? grey : -1);
}

TEST(Nav2Save, WritesThreeGreysInTrinary) {
  const GreySaveOptions options;
  EXPECT_EQ(SavedGrey(options, 0), (GreyAlpha{254}));
  EXPECT_EQ(SavedGrey(options, 25), (GreyAlpha{254}));
  EXPECT_EQ(SavedGrey(options, 26), (GreyAlpha{205}));
  EXPECT_EQ(SavedGrey(options, 64), (GreyAlpha{205}));
  EXPECT_EQ(SavedGrey(options, 65), (GreyAlpha{0}));
  EXPECT_EQ(SavedGrey(options, 100), (GreyAlpha{0}));
  EXPECT_EQ(SavedGrey(options, -1), (GreyAlpha{205}));
}

TEST(Nav2Save, ForcesTheThresholdsOfTrinaryOnly) {
  const GreySaveOptions trinary{.mode = MapMode::kTrinary, .occupied_thresh = 0.9, .free_thresh = 0.1};
  EXPECT_EQ(InterpretationOfSaved(trinary), Reading(MapMode::kTrinary, 0.65, 0.196));
  const GreySaveOptions scale{.mode = MapMode::kScale, .occupied_thresh = 0.9, .free_thresh = 0.1};
  EXPECT_EQ(InterpretationOfSaved(scale), Reading(MapMode::kScale, 0.9, 0.1));
}

TEST(Nav2Save, WritesScaleAndRaw) {
  const GreySaveOptions scale{.mode = MapMode::kScale};
  EXPECT_EQ(SavedGrey(scale, 0), (GreyAlpha{255}));
  EXPECT_EQ(SavedGrey(scale, 1), (GreyAlpha{252}));
  EXPECT_EQ(SavedGrey(scale, 100), (GreyAlpha{0}));
  EXPECT_EQ(SavedGrey(scale, -1), (GreyAlpha{128, 0}));
  const GreySaveOptions raw{.mode = MapMode::kRaw};
  EXPECT_EQ(SavedGrey(raw, 73), (GreyAlpha{73}));
  EXPECT_EQ(SavedGrey(raw, -1), (GreyAlpha{255}));
}

TEST(Nav2Save, SavedValuesLoadUnchanged) {
  const GreySaveOptions raw{.mode = MapMode::kRaw};
  for (int value = -1; value <= 100; ++value) {
    const auto saved = SavedGrey(raw, static_cast<std::int8_t>(value));
    EXPECT_EQ(LoadedValue(InterpretationOfSaved(raw), saved.grey), value);
  }
  const GreySaveOptions trinary;
  for (const int value : {-1, 0, 100}) {
    const auto saved = SavedGrey(trinary, static_cast<std::int8_t>(value));
    EXPECT_EQ(LoadedValue(InterpretationOfSaved(trinary), saved.grey), value);
  }
  // scale: the ends are cut by the thresholds, and 0.4 percent of rounding stretches to one value in between.
  const GreySaveOptions scale{.mode = MapMode::kScale, .occupied_thresh = 1.0, .free_thresh = 0.0};
  for (int value = -1; value <= 100; ++value) {
    const auto saved = SavedGrey(scale, static_cast<std::int8_t>(value));
    EXPECT_EQ(LoadedValue(InterpretationOfSaved(scale), saved.grey, saved.alpha), value);
  }
}

TEST(Nav2Save, RefusesThresholdsThatCross) {
  EXPECT_OK(GreySaveOptions{}.Validate());
  const GreySaveOptions crossed{.occupied_thresh = 0.2, .free_thresh = 0.2};
  EXPECT_STATUS(crossed.Validate(), absl::StatusCode::kInvalidArgument, HasSubstr("free_thresh"));
}

TEST(OccupancyCell, CarriesEveryOccupancyValue) {
  for (int value = -1; value <= 100; ++value) {
    EXPECT_EQ(OccupancyValueOfCell(CellFromOccupancyValue(static_cast<std::int8_t>(value))), value);
  }
  EXPECT_EQ(CellFromOccupancyValue(101), kUnknownCell);
}

}  // namespace
}  // namespace enfilade::grid
