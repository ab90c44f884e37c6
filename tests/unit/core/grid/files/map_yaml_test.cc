// SPDX-License-Identifier: Apache-2.0
#include "core/grid/files/map_yaml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <string>

#include "tests/support/status_assertions.h"

namespace enfilade::grid {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr char kNav2[] =
    "image: depot.pgm\n"
    "mode: scale\n"
    "resolution: 0.0125\n"
    "origin: [-10.326469, 1e-3, -0.5]\n"
    "negate: 1\n"
    "occupied_thresh: 0.65\n"
    "free_thresh: 0.25\n";

// kNav2 with the line of `key` replaced; with "" the line is gone.
std::string With(const std::string& key, const std::string& line) {
  std::string text = kNav2;
  const std::size_t begin = text.find(key + ":");
  return text.replace(begin, text.find('\n', begin) + 1 - begin, line.empty() ? "" : line + "\n");
}

TEST(MapYaml, ReadsAllKeys) {
  ASSERT_OK_AND_ASSIGN(const ParsedMapYaml parsed, ParseMapYaml(kNav2, MapDialect::kRos1));
  EXPECT_EQ(parsed.yaml.image, "depot.pgm");
  EXPECT_EQ(parsed.yaml.resolution, 0.0125);
  EXPECT_EQ(parsed.yaml.origin, (Pose2{-10.326469, 0.001, -0.5}));
  EXPECT_EQ(parsed.yaml.interpretation, (GreyInterpretation{.mode = MapMode::kScale,
                                                            .dialect = MapDialect::kRos1,
                                                            .negate = true,
                                                            .occupied_thresh = 0.65,
                                                            .free_thresh = 0.25}));
  EXPECT_THAT(parsed.warnings, IsEmpty());
}

TEST(MapYaml, TakesModeForTrinaryWhereAbsent) {
  ASSERT_OK_AND_ASSIGN(const ParsedMapYaml parsed, ParseMapYaml(With("mode", ""), MapDialect::kNav2));
  EXPECT_EQ(parsed.yaml.interpretation.mode, MapMode::kTrinary);
}

TEST(MapYaml, TakesNegateAsNumberOrWord) {
  for (const auto& [text, expected] : {std::pair{"0", false}, {"2", true}, {"true", true}, {"no", false}}) {
    ASSERT_OK_AND_ASSIGN(const ParsedMapYaml parsed,
                         ParseMapYaml(With("negate", std::string("negate: ") + text), MapDialect::kNav2));
    EXPECT_EQ(parsed.yaml.interpretation.negate, expected) << text;
  }
}

TEST(MapYaml, IgnoresUnknownKeysWithAWarning) {
  ASSERT_OK_AND_ASSIGN(const ParsedMapYaml parsed,
                       ParseMapYaml(std::string(kNav2) + "floor: [1, {a: b}]\n", MapDialect::kNav2));
  EXPECT_THAT(parsed.warnings, ElementsAre(AllOf(HasSubstr("'floor'"), HasSubstr("line 8"))));
}

TEST(MapYaml, WarnsOfCrossedThresholds) {
  ASSERT_OK_AND_ASSIGN(const ParsedMapYaml parsed,
                       ParseMapYaml(With("free_thresh", "free_thresh: 0.7"), MapDialect::kNav2));
  EXPECT_THAT(parsed.warnings, ElementsAre(HasSubstr("free_thresh")));
}

struct BadYaml {
  std::string text;
  std::string message;
  std::string place;
};

void PrintTo(const BadYaml& bad, std::ostream* os) { *os << bad.message << " " << bad.place; }

class BadMapYaml : public ::testing::TestWithParam<BadYaml> {};
INSTANTIATE_TEST_SUITE_P(
    MapYaml, BadMapYaml,
    ::testing::Values(BadYaml{"", "not a list", ""}, BadYaml{"just words", "not a list", ""},
                      BadYaml{"a: [1, 2", "the map's YAML", "line"}, BadYaml{"a: b: c", "the map's YAML", "line 1"},
                      BadYaml{"P5\n2 2\n255\nabcd", "not a list", ""}, BadYaml{With("image", ""), "no 'image'", ""},
                      BadYaml{With("image", "image: \"\""), "'image' is not a file name", "line 1"},
                      BadYaml{With("image", "image: [a]"), "'image' is not a file name", "line 1"},
                      BadYaml{With("resolution", ""), "no 'resolution'", ""},
                      BadYaml{With("resolution", "resolution: fine"), "'resolution' is not a number", "line 3"},
                      BadYaml{With("resolution", "resolution: 0"), "'resolution' is 0", "line 3"},
                      BadYaml{With("resolution", "resolution: -0.05"), "'resolution' is -0.05", "line 3"},
                      BadYaml{With("resolution", "resolution: .nan"), "not finite", "line 3"},
                      BadYaml{With("resolution", "resolution: .inf"), "not finite", "line 3"},
                      BadYaml{With("origin", "origin: 1.0"), "'origin' is not a list of three", "line 4"},
                      BadYaml{With("origin", "origin: [1, 2]"), "'origin' is not a list of three", "line 4"},
                      BadYaml{With("origin", "origin: [1, 2, 3, 4]"), "'origin' is not a list of three", "line 4"},
                      BadYaml{With("origin", "origin: [1, b, 3]"), "'origin[1]' is not a number", "line 4"},
                      BadYaml{With("origin", "origin: [1, 2, .nan]"), "'origin[2]' is nan", "line 4"},
                      BadYaml{With("negate", ""), "no 'negate'", ""},
                      BadYaml{With("negate", "negate: 0.5"), "'negate' is neither", "line 5"},
                      BadYaml{With("occupied_thresh", ""), "no 'occupied_thresh'", ""},
                      BadYaml{With("occupied_thresh", "occupied_thresh: {}"), "'occupied_thresh' is not", "line 6"},
                      BadYaml{With("free_thresh", "free_thresh:"), "no 'free_thresh'", ""},
                      BadYaml{With("free_thresh", "free_thresh: -.inf"), "not finite", "line 7"},
                      BadYaml{With("mode", "mode: binary"), "'mode' is 'binary'", "line 2"},
                      BadYaml{std::string(2 << 20, '#'), "2097152 bytes", ""},
                      BadYaml{std::string(100'000, '['), "the map's YAML", ""}));

TEST_P(BadMapYaml, IsRefusedNamingKeyAndLine) {
  EXPECT_STATUS(ParseMapYaml(GetParam().text, MapDialect::kNav2), absl::StatusCode::kInvalidArgument,
                AllOf(HasSubstr(GetParam().message), HasSubstr(GetParam().place)));
}

TEST(MapYaml, WritesNav2sKeysInItsOrder) {
  EXPECT_EQ(FormatMapYaml({.image = "a.pgm", .resolution = 0.05, .origin = {-10, 2.5, 0}, .interpretation = {}}),
            "image: a.pgm\n"
            "mode: trinary\n"
            "resolution: 0.05\n"
            "origin: [-10.0, 2.5, 0.0]\n"
            "negate: 0\n"
            "occupied_thresh: 0.65\n"
            "free_thresh: 0.196\n");
}

TEST(MapYaml, RestoresEveryDouble) {
  std::mt19937_64 rng(3);
  std::uniform_real_distribution<double> exponent(-18.0, 18.0);
  std::uniform_real_distribution<double> mantissa(-1.0, 1.0);
  for (int i = 0; i < 2000; ++i) {
    const auto number = [&] { return mantissa(rng) * std::pow(10.0, exponent(rng)); };
    MapYaml yaml{.image = "m.png", .resolution = std::abs(number()), .origin = {number(), number(), number()}};
    yaml.interpretation = {
        .mode = MapMode::kRaw, .negate = i % 2 == 0, .occupied_thresh = number(), .free_thresh = number()};
    ASSERT_OK_AND_ASSIGN(const ParsedMapYaml parsed, ParseMapYaml(FormatMapYaml(yaml), MapDialect::kNav2));
    ASSERT_EQ(parsed.yaml.resolution, yaml.resolution);
    ASSERT_EQ(parsed.yaml.origin, yaml.origin);
    ASSERT_EQ(parsed.yaml.interpretation, yaml.interpretation);
  }
}

TEST(MapYaml, WritesSmallNumbersSoThatNoReaderTakesThemForWords) {
  EXPECT_THAT(FormatMapYaml({.image = "a.pgm", .resolution = 1e-5, .origin = {1e20, 0, 0}, .interpretation = {}}),
              AllOf(HasSubstr("resolution: 1.0e-05\n"), HasSubstr("[1.0e+20, ")));
}

}  // namespace
}  // namespace enfilade::grid
