// SPDX-License-Identifier: Apache-2.0
// Map files that nobody wrote by hand: random ones that must round-trip, and damaged ones that must not do harm.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "core/grid/files/json_map.h"
#include "core/grid/files/json_scanner.h"
#include "core/grid/files/map_files.h"
#include "core/grid/files/map_yaml.h"
#include "core/grid/files/pgm_codec.h"
#include "core/grid/files/png_codec.h"
#include "tests/support/status_assertions.h"

namespace enfilade::grid {
namespace {

std::string RandomPgm(std::mt19937& random, int width, int height, int max_value) {
  std::string bytes = "P5";
  const auto gap = [&] {
    for (std::uint32_t i = 0; i < 1 + random() % 2; ++i) bytes += " \n\t\r"[random() % 4];
    if (random() % 3 == 0) bytes += "# made by " + std::to_string(random()) + "\n";
  };
  gap();
  bytes += std::to_string(width);
  gap();
  bytes += std::to_string(height);
  gap();
  bytes += std::to_string(max_value) + "\n";
  for (int i = 0; i < width * height; ++i) {
    bytes += static_cast<char>(random() % (static_cast<std::uint32_t>(max_value) + 1));
  }
  if (random() % 2 == 0) bytes += "\n";
  return bytes;
}

std::string RandomYaml(std::mt19937& random, const std::string& image) {
  MapYaml yaml;
  yaml.image = image;
  yaml.resolution = 0.001 * (1 + random() % 1000);
  yaml.origin = {0.37 * (static_cast<int>(random() % 200) - 100), -0.11 * (random() % 100), 0.01 * (random() % 300)};
  yaml.interpretation = {.mode = static_cast<MapMode>(random() % 3),
                         .negate = random() % 2 == 0,
                         .occupied_thresh = 0.5 + 0.001 * (random() % 500),
                         .free_thresh = 0.001 * (random() % 500)};
  return FormatMapYaml(yaml);
}

class MapFileSeeds : public ::testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(MapFiles, MapFileSeeds, ::testing::Range(1U, 41U));

TEST_P(MapFileSeeds, AnyPgmIsRestoredByteForByte) {
  std::mt19937 random(GetParam());
  const int max_value = random() % 3 == 0 ? 1 + static_cast<int>(random() % 254) : 255;
  const std::string pgm = RandomPgm(random, 1 + random() % 30, 1 + random() % 30, max_value);
  const std::vector<MapFile> files = {{"a.yaml", RandomYaml(random, "a.pgm")}, {"a.pgm", pgm}};
  for (const MapDialect dialect : {MapDialect::kNav2, MapDialect::kRos1}) {
    ASSERT_OK_AND_ASSIGN(const ImportedMap map, ImportFiles(files, dialect));
    ASSERT_OK_AND_ASSIGN(const auto rendered, RenderFiles(map.raster, "a", {}));
    EXPECT_EQ(rendered[0].bytes, pgm);
    EXPECT_EQ(rendered[1].bytes, files[0].bytes);
  }
}

TEST_P(MapFileSeeds, AnyPngKeepsItsSamples) {
  std::mt19937 random(GetParam() + 1000);
  const int channels = random() % 2 == 0 ? 1 : 4;
  PixelImage image{.width = 1 + static_cast<int>(random() % 20),
                   .height = 1 + static_cast<int>(random() % 20),
                   .channels = channels,
                   .samples = {}};
  for (int i = 0; i < image.width * image.height; ++i) {
    const auto grey = static_cast<std::uint8_t>(random());
    image.samples.insert(image.samples.end(), channels == 1 ? 1 : 3, grey);
    if (channels == 4) image.samples.push_back(static_cast<std::uint8_t>(random()));
  }
  image.samples.back() = 7;  // an image whose pixels are all opaque would lose its alpha channel
  ASSERT_OK_AND_ASSIGN(const std::string png, EncodePng(image));
  ASSERT_OK_AND_ASSIGN(
      const ImportedMap map,
      ImportFiles(std::vector<MapFile>{{"a.yaml", RandomYaml(random, "a.png")}, {"a.png", png}}, MapDialect::kNav2));
  ASSERT_OK_AND_ASSIGN(const auto rendered, RenderFiles(map.raster, "a", {.format = MapFileFormat::kPng}));
  ASSERT_OK_AND_ASSIGN(const PixelImage back, DecodePng(rendered[0].bytes));
  EXPECT_EQ(back, image);
}

TEST_P(MapFileSeeds, AnyJsonMapKeepsItsNumbers) {
  std::mt19937 random(GetParam() + 2000);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const int columns = 1 + static_cast<int>(random() % 30);
  const int rows = 1 + static_cast<int>(random() % 30);
  const double step = 0.001 * (1 + random() % 500);
  const double xmin = 10.0 * (unit(random) - 0.5);
  const UnitLimits limits{xmin, xmin + (columns - 1) * step, -xmin, -xmin + (rows - 1) * step, step, step, 3.0};
  std::vector<double> values;
  for (int i = 0; i < columns * rows; ++i) values.push_back(unit(random));
  ASSERT_OK_AND_ASSIGN(const ParsedJsonMap parsed, ParseJsonMap(FormatJsonMap(limits, values)));
  EXPECT_EQ(std::get<UnitCells>(parsed.raster.cells).values, values);
  EXPECT_EQ(std::get<UnitCells>(parsed.raster.cells).limits, limits);
  EXPECT_EQ(parsed.raster.geometry.width, columns);
  EXPECT_EQ(parsed.raster.geometry.height, rows);
}

// Whatever is in the files, an import ends with INVALID_ARGUMENT or with a valid raster.
void ExpectHarmless(const std::vector<MapFile>& files) {
  for (const MapDialect dialect : {MapDialect::kNav2, MapDialect::kRos1}) {
    const auto map = ImportFiles(files, dialect);
    if (map.ok()) {
      EXPECT_OK(Validate(map->raster));
    } else {
      EXPECT_CODE(map, absl::StatusCode::kInvalidArgument);
    }
  }
}

std::string Mutated(std::string bytes, std::mt19937& random) {
  for (std::uint32_t changes = 1 + random() % 4; changes > 0; --changes) {
    const std::size_t at = random() % bytes.size();
    switch (random() % 4) {
      case 0:
        bytes[at] = static_cast<char>(random());
        break;
      case 1:
        bytes.erase(at, 1 + random() % 4);
        break;
      case 2:
        bytes.insert(at, std::string(1 + random() % 4, "0123456789.eE-+[]{}:,\" \n"[random() % 24]));
        break;
      default:
        bytes.insert(at, bytes.substr(random() % bytes.size(), random() % 20));
    }
    if (bytes.empty()) bytes = "x";
  }
  return bytes;
}

TEST_P(MapFileSeeds, MutatedFilesAreHarmless) {
  std::mt19937 random(GetParam() + 3000);
  const std::string yaml = RandomYaml(random, "a.pgm");
  const std::string pgm = RandomPgm(random, 5, 4, 255);
  ASSERT_OK_AND_ASSIGN(const std::string png,
                       EncodePng(PixelImage{.width = 2, .height = 2, .channels = 1, .samples = {1, 2, 3, 4}}));
  const std::string json = FormatJsonMap(UnitLimits{0, 1, 0, 1, 1, 1, 10}, std::vector<double>{0, 0.5, 1, 0.25});
  for (int trial = 0; trial < 50; ++trial) {
    ExpectHarmless({{"a.yaml", Mutated(yaml, random)}, {"a.pgm", pgm}});
    ExpectHarmless({{"a.yaml", yaml}, {"a.pgm", Mutated(pgm, random)}});
    ExpectHarmless({{"a.yaml", yaml}, {"a.pgm", Mutated(png, random)}});
    ExpectHarmless({{"a.json", Mutated(json, random)}});
  }
}

TEST(HostileMapFiles, AreRefusedQuickly) {
  const std::string yaml =
      "image: a.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
      "free_thresh: 0.25\n";
  // Nested collections, aliases of aliases, and documents after the first.
  std::string aliases = yaml + "a: &a [1, 1, 1, 1, 1, 1, 1, 1, 1]\n";
  for (char name = 'b'; name < 'z'; ++name) {
    const std::string last = std::string("*") + static_cast<char>(name - 1);
    aliases += std::string(1, name) + ": &" + name + " [" + last + ", " + last + ", " + last + ", " + last + "]\n";
  }
  ASSERT_OK_AND_ASSIGN(const ParsedMapYaml parsed, ParseMapYaml(aliases, MapDialect::kNav2));
  EXPECT_EQ(parsed.yaml.resolution, 0.05);
  EXPECT_CODE(ParseMapYaml(std::string(200'000, '{'), MapDialect::kNav2), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(ParseMapYaml(std::string(200'000, '-'), MapDialect::kNav2), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(ParseMapYaml(std::string("\xff\xfe\x00", 3), MapDialect::kNav2), absl::StatusCode::kInvalidArgument);
  ExpectHarmless({{"a.json", "{\"data\": [" + std::string(300'000, '0') + "]}"}});
  ExpectHarmless({{"a.json", "{\"data\": [" + std::string(300'000, '[')}});
  ExpectHarmless({{"a.json", std::string("\xef\xbb\xbf{}")}});
  ExpectHarmless({{"a.yaml", yaml}, {"a.pgm", "P5 2147483647 2147483647 255\n"}});
  ExpectHarmless({{"a.yaml", yaml}, {"a.pgm", std::string(1000, 'P')}});
}

// Numbers: JsonScanner accepts exactly what JSON does. nlohmann's parser is the reference.
TEST(JsonScannerNumbers, AcceptsExactlyTheGrammarOfJson) {
  std::mt19937 random(7);
  int accepted = 0;
  for (int trial = 0; trial < 20'000; ++trial) {
    std::string text;
    for (std::uint32_t length = 1 + random() % 6; length > 0; --length) text += "0123456789.eE+-"[random() % 15];
    JsonScanner scanner(text);
    const absl::StatusOr<double> number = scanner.Number();
    const bool whole = number.ok() && scanner.ExpectEnd().ok();
    const nlohmann::json expected = nlohmann::json::parse(text, nullptr, false);
    if (!whole && expected.is_number() && std::abs(expected.get<double>()) < 1e-300) continue;  // underflow is an error
    ASSERT_EQ(whole, expected.is_number()) << text;
    if (!whole) continue;
    ++accepted;
    EXPECT_EQ(*number, expected.get<double>()) << text;
  }
  EXPECT_GT(accepted, 1000);
}

TEST(JsonScannerTokens, SkipsAnyValueAndStopsBehindIt) {
  for (const char* value : {"1", "-0.5e3", "\"text\"", "\"a\\\"b\\\\\"", "true", "false", "null", "[]", "{}",
                            "[1, [2, {}]]", "{\"a\": {\"b\": [null]}}", " [ 1 , 2 ] "}) {
    const std::string text = std::string(value) + " ; rest";
    JsonScanner scanner(text);
    EXPECT_OK(scanner.SkipValue()) << value;
    EXPECT_TRUE(scanner.Accept(';')) << value;
  }
  for (const char* value : {"", "tru", "nul", "[1", "[1,]", "[1 2]", "{\"a\"}", "{\"a\":}", "{a: 1}", "{\"a\": 1,}",
                            "'x'", "NaN", "+1", "}", "\"open"}) {
    JsonScanner scanner(value);
    EXPECT_CODE(scanner.SkipValue(), absl::StatusCode::kInvalidArgument) << value;
  }
}

TEST(JsonScannerTokens, CountsLinesInErrors) {
  JsonScanner scanner("[\n1,\r\n\n  x");
  EXPECT_STATUS(scanner.SkipValue(), absl::StatusCode::kInvalidArgument, ::testing::HasSubstr("(line 4)"));
}

TEST(SafeStemProperties, GiveShortSafeNames) {
  std::mt19937 random(8);
  for (int trial = 0; trial < 2000; ++trial) {
    std::string name;
    for (std::uint32_t length = random() % 100; length > 0; --length) name += static_cast<char>(random());
    const std::string stem = SafeStem(name);
    ASSERT_FALSE(stem.empty());
    EXPECT_LE(stem.size(), 64U);
    EXPECT_EQ(stem.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.-"),
              std::string::npos)
        << stem;
    EXPECT_EQ(std::string("-.").find(stem.front()), std::string::npos) << stem;
    EXPECT_EQ(std::string("-.").find(stem.back()), std::string::npos) << stem;
    EXPECT_EQ(SafeStem(stem), stem);
  }
}

}  // namespace
}  // namespace enfilade::grid
