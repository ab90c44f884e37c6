// SPDX-License-Identifier: Apache-2.0
#include "core/grid/files/json_map.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "tests/support/status_assertions.h"

namespace enfilade::grid {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// 3 x 2 cells with their centres on the limits.
constexpr char kSmall[] = R"({
  "xmin": -1, "xmax": 1,
  "ymin": 0, "ymax": 1,
  "stepx": 1.0, "stepy": 1e0,
  "level": 10,
  "data": [0.1, 0.2, 0.3,
           0.4, 0.5, 1]
})";

std::string Replaced(std::string_view from, std::string_view to) {
  std::string text = kSmall;
  const std::size_t begin = text.find(from);
  return text.replace(begin, from.size(), to);
}

const UnitCells& UnitOf(const MapRaster& raster) { return std::get<UnitCells>(raster.cells); }

TEST(JsonMap, TakesLimitsForCentresOfTheOuterCells) {
  ASSERT_OK_AND_ASSIGN(const ParsedJsonMap parsed, ParseJsonMap(kSmall));
  EXPECT_EQ(parsed.raster.geometry,
            (GridGeometry{.resolution = 1.0, .T_map_grid = {-1.5, -0.5, 0.0}, .width = 3, .height = 2}));
  EXPECT_THAT(UnitOf(parsed.raster).values, ElementsAre(0.1, 0.2, 0.3, 0.4, 0.5, 1.0));
  EXPECT_EQ(UnitOf(parsed.raster).limits, (UnitLimits{-1, 1, 0, 1, 1, 1, 10}));
  EXPECT_THAT(parsed.warnings, IsEmpty());
}

TEST(JsonMap, TakesLimitsForEdgesWhereTheDataAreOneLessEachWay) {
  ASSERT_OK_AND_ASSIGN(const ParsedJsonMap parsed, ParseJsonMap(Replaced(R"(0.1, 0.2, 0.3,
           0.4, 0.5, 1)",
                                                                         "0.1, 0.2")));
  EXPECT_EQ(parsed.raster.geometry,
            (GridGeometry{.resolution = 1.0, .T_map_grid = {-1.0, 0.0, 0.0}, .width = 2, .height = 1}));
}

// The format's reference map: 6 m at 0.015 m are 401 cells a side, although 6 / 0.015 is not 400 in binary.
std::string ReferenceMap(int side, std::string_view value) {
  std::string text =
      R"({"xmin": -3, "xmax": 3, "ymin": -3, "ymax": 3, "stepx": 0.015, "stepy": 0.015, "Level": 20, "data": [)";
  for (int i = 0; i < side * side; ++i) text += fmt::format("{}{}", i == 0 ? "" : ", ", value);
  return text + "]}";
}

TEST(JsonMap, ReadsA401x401Map) {
  ASSERT_OK_AND_ASSIGN(const ParsedJsonMap parsed, ParseJsonMap(ReferenceMap(401, "0.14084787333043428")));
  EXPECT_EQ(parsed.raster.geometry.width, 401);
  EXPECT_EQ(parsed.raster.geometry.height, 401);
  EXPECT_DOUBLE_EQ(parsed.raster.geometry.T_map_grid.x, -3.0075);
  EXPECT_EQ(UnitOf(parsed.raster).limits.level, 20);
  EXPECT_EQ(UnitOf(parsed.raster).values.back(), 0.14084787333043428);
}

TEST(JsonMap, ReadsA400x400Map) {
  ASSERT_OK_AND_ASSIGN(const ParsedJsonMap parsed, ParseJsonMap(ReferenceMap(400, "0")));
  EXPECT_EQ(parsed.raster.geometry.width, 400);
  EXPECT_DOUBLE_EQ(parsed.raster.geometry.T_map_grid.x, -3.0);
}

TEST(JsonMap, RestoresEveryNumber) {
  std::mt19937_64 rng(9);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  UnitLimits limits{-3, 3, -3, 3, 0.015, 0.015, 10};
  std::vector<double> values = {0.0, 1.0, 5e-324, 1e-5, 0.1 + 0.2, 0.14084787333043422, 0.14084787333043434};
  while (values.size() < 401 * 401) values.push_back(unit(rng));
  const std::string text = FormatJsonMap(limits, values);
  ASSERT_OK_AND_ASSIGN(const ParsedJsonMap parsed, ParseJsonMap(text));
  EXPECT_EQ(UnitOf(parsed.raster).values, values);
  EXPECT_EQ(UnitOf(parsed.raster).limits, limits);
  EXPECT_EQ(FormatJsonMap(UnitOf(parsed.raster).limits, UnitOf(parsed.raster).values), text);
}

TEST(JsonMap, WritesTheFormatsLayout) {
  EXPECT_EQ(FormatJsonMap(UnitLimits{-3, 3, -3, 3, 0.015, 0.015, 10}, std::vector<double>{0.25, 1.0}),
            R"({
  "xmin": -3,
  "xmax": 3,
  "ymin": -3,
  "ymax": 3,
  "stepx": 0.015,
  "stepy": 0.015,
  "level": 10,
  "data": [
0.25,
1
  ]
}
)");
}

TEST(JsonMap, CarriesEveryKnownCellOfAGrid) {
  std::vector<std::uint8_t> cells;
  for (int cell = 1; cell < 256; ++cell) cells.push_back(static_cast<std::uint8_t>(cell));
  const GridGeometry geometry{.resolution = 0.05, .T_map_grid = {-3.15, 7.2, 0.0}, .width = 255, .height = 1};
  ASSERT_OK_AND_ASSIGN(const UnitLimits limits, UnitLimitsOf(geometry, 10));
  ASSERT_OK_AND_ASSIGN(const ParsedJsonMap parsed, ParseJsonMap(FormatJsonMap(limits, cells)));
  EXPECT_EQ(ToOccupancyGrid(parsed.raster).cells, cells);
  EXPECT_EQ(parsed.raster.geometry.width, 255);
  EXPECT_NEAR(parsed.raster.geometry.T_map_grid.x, -3.15, 1e-12);
  EXPECT_NEAR(parsed.raster.geometry.T_map_grid.y, 7.2, 1e-12);
}

TEST(JsonMap, WritesUnknownCellsAsOneHalf) {
  const std::vector<std::uint8_t> cells = {kUnknownCell};
  EXPECT_THAT(FormatJsonMap(UnitLimits{}, cells), HasSubstr("[\n0.5\n"));
}

TEST(JsonMap, CannotHoldARotation) {
  EXPECT_STATUS(UnitLimitsOf({.resolution = 1, .T_map_grid = {0, 0, 0.5}, .width = 1, .height = 1}, 10),
                absl::StatusCode::kInvalidArgument, HasSubstr("yaw"));
}

TEST(JsonMap, IgnoresUnknownKeysWithAWarning) {
  ASSERT_OK_AND_ASSIGN(
      const ParsedJsonMap parsed,
      ParseJsonMap(Replaced(R"("level")", R"("by": {"a\"": [1, {}, [], "]"], "b": null, "c": true}, "level")")));
  EXPECT_THAT(parsed.warnings, ElementsAre(HasSubstr("'by'")));
}

struct BadJson {
  std::string text;
  std::string message;
};

void PrintTo(const BadJson& bad, std::ostream* os) { *os << bad.message; }

class BadJsonMap : public ::testing::TestWithParam<BadJson> {};
INSTANTIATE_TEST_SUITE_P(
    JsonMap, BadJsonMap,
    ::testing::Values(
        BadJson{"", "'{'"}, BadJson{"[]", "'{'"}, BadJson{"{}", "no 'xmin'"}, BadJson{"{\"xmin", "within a string"},
        BadJson{"{\"xmin\\", "within a string"}, BadJson{std::string(kSmall) + "x", "content after"},
        BadJson{Replaced("\"ymax\": 1,", ""), "no 'ymax'"}, BadJson{Replaced("\"level\": 10,", ""), "no 'level'"},
        BadJson{Replaced("\"xmin\": -1", "\"xmin\": -1, \"xmin\": -1"), "'xmin' is given twice"},
        BadJson{Replaced("\"xmin\": -1", "\"xmin\": \"-1\""), "'xmin'"},
        BadJson{Replaced("\"xmin\": -1", "\"xmin\": 1e999"), "range (line 2)"},
        BadJson{Replaced("\"xmin\": -1", "\"xmin\": -inf"), "'xmin'"},
        BadJson{Replaced("\"xmin\": -1", "\"xmin\": 2"), "xmin 2"},
        BadJson{Replaced("\"xmin\": -1", "\"xmin\": -1e300"), "xmin -1e+300"},
        BadJson{Replaced("\"xmin\": -1", "\"xmin\": -1.3"), "not a multiple of stepx"},
        BadJson{Replaced("\"stepx\": 1.0", "\"stepx\": 0"), "stepx is 0"},
        BadJson{Replaced("\"stepx\": 1.0", "\"stepx\": -1"), "stepx is -1"},
        BadJson{Replaced("\"stepy\": 1e0", "\"stepy\": 0.5"), "stepx 1 and stepy 0.5 differ"},
        BadJson{Replaced("\"level\": 10", "\"level\": ten"), "'level'"},
        BadJson{Replaced("[0.1, 0.2, 0.3,\n           0.4, 0.5, 1]", "{}"), "'data' is not an array"},
        BadJson{Replaced("[0.1, 0.2, 0.3,\n           0.4, 0.5, 1]", "[]"), "data has 0 numbers"},
        BadJson{Replaced("0.5, 1]", "0.5]"), "data has 5 numbers"},
        BadJson{Replaced("1]", "1, 1]"), "data has 7 numbers"}, BadJson{Replaced("0.4", "NaN"), "data[3]"},
        BadJson{Replaced("0.4", "nan"), "data[3]"}, BadJson{Replaced("0.4", "\"0.4\""), "data[3]"},
        BadJson{Replaced("0.4", "null"), "data[3]"}, BadJson{Replaced("0.4", "[0.4]"), "data[3]"},
        BadJson{Replaced("0.4", "01"), "data[3]"}, BadJson{Replaced("0.4", ".4"), "data[3]"},
        BadJson{Replaced("0.4", "1."), "data[3]"},
        BadJson{Replaced("0.4", "-0.4"), "data[3] is -0.4: expected 0 to 1 (line 7)"},
        BadJson{Replaced("0.4", "1.0000001"), "data[3] is 1.0000001"}, BadJson{Replaced("0.4,", "0.4 "), "data[4]"},
        BadJson{Replaced("\"data\"", "\"data\": [], \"data\""), "'data' is given twice"},
        BadJson{Replaced("\"data\"", "\"deta\""), "no 'data'"},
        BadJson{R"({"xmin":0,"xmax":1e5,"ymin":0,"ymax":1e5,"stepx":1,"stepy":1,"level":1,"data":[0]})",
                "100001 x 100001"},
        BadJson{"{\"a\": " + std::string(100'000, '['), "nested too deeply"}));

TEST_P(BadJsonMap, IsRefusedNamingTheField) {
  EXPECT_STATUS(ParseJsonMap(GetParam().text), absl::StatusCode::kInvalidArgument, HasSubstr(GetParam().message));
}

TEST(JsonMap, RefusesEveryTruncation) {
  const std::string_view whole = kSmall;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(ParseJsonMap(whole.substr(0, size)).ok()) << size;
  }
}

}  // namespace
}  // namespace enfilade::grid
