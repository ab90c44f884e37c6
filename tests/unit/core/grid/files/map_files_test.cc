// SPDX-License-Identifier: Apache-2.0
#include "core/grid/files/map_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "core/grid/files/png_codec.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::grid {
namespace {

namespace fs = std::filesystem;
using std::string_literals::operator""s;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr char kYaml[] =
    "image: room.pgm\n"
    "resolution: 0.05\n"
    "origin: [-1.5, 2.0, 0.25]\n"
    "negate: 0\n"
    "occupied_thresh: 0.65\n"
    "free_thresh: 0.25\n";
constexpr char kPgm[] = "P5\n# by hand\n3 2\n255\n\x01\xfe\xcd\x01\x02\x03\n";

std::vector<MapFile> Room() { return {{"room.yaml", kYaml}, {"room.pgm", kPgm}}; }

OccupancyGrid SmallGrid() {
  return {{.resolution = 0.05, .T_map_grid = {-0.1, 0.2, 0.0}, .width = 4, .height = 2},
          {1, 255, kUnknownCell, 128, 60, 200, 1, 1}};
}

std::string ReadBytes(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

TEST(MapFiles, ExportsAnImportedPgmByteForByteWithItsThresholds) {
  ASSERT_OK_AND_ASSIGN(const ImportedMap map, ImportFiles(Room(), MapDialect::kNav2));
  EXPECT_EQ(map.format, MapFileFormat::kPgm);
  EXPECT_THAT(map.warnings, IsEmpty());
  ASSERT_OK_AND_ASSIGN(const std::vector<MapFile> files, RenderFiles(map.raster, "my room", {}));
  ASSERT_EQ(files.size(), 2U);
  EXPECT_EQ(files[0].name, "my-room.pgm");
  EXPECT_EQ(files[0].bytes, kPgm);
  EXPECT_EQ(files[1].name, "my-room.yaml");
  EXPECT_EQ(files[1].bytes,
            "image: my-room.pgm\n"
            "mode: trinary\n"
            "resolution: 0.05\n"
            "origin: [-1.5, 2.0, 0.25]\n"
            "negate: 0\n"
            "occupied_thresh: 0.65\n"
            "free_thresh: 0.25\n");
}

TEST(MapFiles, FindsTheImageByItsNameWithoutFolders) {
  std::vector<MapFile> files = Room();
  files[0].bytes.replace(files[0].bytes.find("room.pgm"), 8, "/home/someone/maps/room.pgm");
  EXPECT_OK(ImportFiles(files, MapDialect::kNav2));
  std::swap(files[0], files[1]);
  EXPECT_OK(ImportFiles(files, MapDialect::kNav2));
  ASSERT_OK_AND_ASSIGN(const std::string image, ImageNameOf(files[1].bytes));
  EXPECT_EQ(image, "/home/someone/maps/room.pgm");
}

TEST(MapFiles, ExportsAnImportedJsonMapNumberForNumber) {
  const std::string json =
      "{\n  \"xmin\": -3,\n  \"xmax\": -2.985,\n  \"ymin\": 0,\n  \"ymax\": 0,\n  \"stepx\": 0.015,\n"
      "  \"stepy\": 0.015,\n  \"level\": 20,\n  \"data\": [\n0.14084787333043428,\n1\n  ]\n}\n";
  ASSERT_OK_AND_ASSIGN(const ImportedMap map, ImportFiles(std::vector<MapFile>{{"m.JSON", json}}, MapDialect::kNav2));
  EXPECT_EQ(map.format, MapFileFormat::kJson);
  ASSERT_OK_AND_ASSIGN(const auto files, RenderFiles(map.raster, "m", {.format = MapFileFormat::kJson}));
  ASSERT_EQ(files.size(), 1U);
  EXPECT_EQ(files[0].name, "m.json");
  EXPECT_EQ(files[0].bytes, json);
}

TEST(MapFiles, AGridIsSavedAsNav2Saves) {
  ASSERT_OK_AND_ASSIGN(const auto files, RenderFiles(FromOccupancyGrid(SmallGrid()), "g", {}));
  EXPECT_EQ(files[0].bytes, "P5\n4 2\n255\n\xfe\x00\xfe\xfe\xfe\x00\xcd\xcd"s);
  EXPECT_THAT(files[1].bytes, AllOf(HasSubstr("occupied_thresh: 0.65\nfree_thresh: 0.196\n"), HasSubstr("negate: 0\n"),
                                    HasSubstr("mode: trinary\n"), HasSubstr("image: g.pgm\n")));
}

// Every way out and in again, for every kind of raster.
TEST(MapFiles, AnyRasterSurvivesAnyFormat) {
  ASSERT_OK_AND_ASSIGN(ImportedMap pgm, ImportFiles(Room(), MapDialect::kNav2));
  pgm.raster.geometry.T_map_grid.yaw = 0.0;  // which JSON cannot say
  const MapRaster unit{{.resolution = 0.5, .T_map_grid = {-0.25, -0.25, 0}, .width = 2, .height = 1},
                       UnitCells{{0.0, 0.9}, {0, 0.5, 0, 0, 0.5, 0.5, 10}}};
  MapRaster transparent = pgm.raster;
  std::get<GreyCells>(transparent.cells).alpha = {255, 255, 0, 255, 255, 255};
  for (const MapRaster& raster : {FromOccupancyGrid(SmallGrid()), pgm.raster, transparent, unit}) {
    for (const MapFileFormat format : {MapFileFormat::kPgm, MapFileFormat::kPng, MapFileFormat::kJson}) {
      ASSERT_OK_AND_ASSIGN(const auto files, RenderFiles(raster, "x", {.format = format}));
      ASSERT_OK_AND_ASSIGN(const ImportedMap back, ImportFiles(files, MapDialect::kNav2));
      EXPECT_EQ(back.format, format);
      EXPECT_EQ(back.raster.geometry.width, raster.geometry.width);
      EXPECT_EQ(back.raster.geometry.height, raster.geometry.height);
      EXPECT_DOUBLE_EQ(back.raster.geometry.resolution, raster.geometry.resolution);
      EXPECT_NEAR(back.raster.geometry.T_map_grid.x, raster.geometry.T_map_grid.x, 1e-12);
      EXPECT_NEAR(back.raster.geometry.T_map_grid.y, raster.geometry.T_map_grid.y, 1e-12);
      // Free, occupied and unknown survive all of them (in JSON unknown is 0.5, which trinary takes for unknown).
      ASSERT_OK_AND_ASSIGN(const auto first, RenderFiles(FromOccupancyGrid(ToOccupancyGrid(raster)), "x", {}));
      ASSERT_OK_AND_ASSIGN(const auto second, RenderFiles(FromOccupancyGrid(ToOccupancyGrid(back.raster)), "x", {}));
      EXPECT_EQ(first[0].bytes, second[0].bytes);
    }
  }
}

TEST(MapFiles, ExportsAnImportedPngWithItsGreysAndAlphas) {
  const PixelImage image{.width = 2,
                         .height = 2,
                         .channels = 4,
                         .samples = {1, 1, 1, 255, 205, 205, 205, 0,  //
                                     9, 9, 9, 100, 254, 254, 254, 255}};
  ASSERT_OK_AND_ASSIGN(const std::string png, EncodePng(image));
  std::string yaml = kYaml;
  yaml.replace(yaml.find("room.pgm"), 8, "room.png");
  ASSERT_OK_AND_ASSIGN(const ImportedMap map,
                       ImportFiles(std::vector<MapFile>{{"room.yml", yaml}, {"room.png", png}}, MapDialect::kNav2));
  EXPECT_EQ(map.format, MapFileFormat::kPng);
  EXPECT_THAT(std::get<GreyCells>(map.raster.cells).grey, ElementsAre(9, 254, 1, 205));
  EXPECT_THAT(std::get<GreyCells>(map.raster.cells).alpha, ElementsAre(100, 255, 255, 0));
  ASSERT_OK_AND_ASSIGN(const auto files, RenderFiles(map.raster, "x", {.format = MapFileFormat::kPng}));
  ASSERT_OK_AND_ASSIGN(const PixelImage decoded, DecodePng(files[0].bytes));
  EXPECT_EQ(decoded, image);
}

TEST(MapFiles, ColoursBecomeGreyByTheDialect) {
  const PixelImage image{.width = 3, .height = 1, .channels = 3, .samples = {255, 0, 0, 0, 255, 0, 7, 7, 7}};
  ASSERT_OK_AND_ASSIGN(const std::string png, EncodePng(image));
  const std::vector<MapFile> files = {{"room.yaml", kYaml}, {"room.pgm", png}};  // by content, not by name
  ASSERT_OK_AND_ASSIGN(const ImportedMap nav2, ImportFiles(files, MapDialect::kNav2));
  EXPECT_THAT(std::get<GreyCells>(nav2.raster.cells).grey, ElementsAre(76, 150, 7));
  EXPECT_THAT(nav2.warnings, ElementsAre(HasSubstr("colours")));
  ASSERT_OK_AND_ASSIGN(const ImportedMap ros1, ImportFiles(files, MapDialect::kRos1));
  EXPECT_THAT(std::get<GreyCells>(ros1.raster.cells).grey, ElementsAre(85, 85, 7));
}

TEST(MapFiles, OpaqueAlphaMattersToRos1Only) {
  const PixelImage image{.width = 1, .height = 1, .channels = 2, .samples = {0, 255}};
  ASSERT_OK_AND_ASSIGN(const std::string png, EncodePng(image));
  const std::vector<MapFile> files = {{"room.yaml", kYaml}, {"room.pgm", png}};
  ASSERT_OK_AND_ASSIGN(const ImportedMap nav2, ImportFiles(files, MapDialect::kNav2));
  EXPECT_THAT(std::get<GreyCells>(nav2.raster.cells).alpha, IsEmpty());
  ASSERT_OK_AND_ASSIGN(const ImportedMap ros1, ImportFiles(files, MapDialect::kRos1));
  EXPECT_THAT(std::get<GreyCells>(ros1.raster.cells).alpha, ElementsAre(255));
}

TEST(MapFiles, ScaleNeedsTransparencyForUnknownCells) {
  const MapRaster raster = FromOccupancyGrid(SmallGrid());
  MapFileOptions options{.format = MapFileFormat::kPgm, .save = {.mode = MapMode::kScale}};
  EXPECT_STATUS(RenderFiles(raster, "x", options), absl::StatusCode::kInvalidArgument, HasSubstr("scale"));
  options.format = MapFileFormat::kPng;
  ASSERT_OK_AND_ASSIGN(const auto files, RenderFiles(raster, "x", options));
  EXPECT_THAT(files[1].bytes, HasSubstr("mode: scale\n"));
  ASSERT_OK_AND_ASSIGN(const PixelImage image, DecodePng(files[0].bytes));
  EXPECT_EQ(image.channels, 4);
  ASSERT_OK_AND_ASSIGN(const ImportedMap back, ImportFiles(files, MapDialect::kNav2));
  EXPECT_EQ(ToOccupancyGrid(back.raster).cells[2], kUnknownCell);
}

TEST(MapFiles, JsonCannotHoldARotation) {
  ASSERT_OK_AND_ASSIGN(const ImportedMap map, ImportFiles(Room(), MapDialect::kNav2));
  EXPECT_STATUS(RenderFiles(map.raster, "x", {.format = MapFileFormat::kJson}), absl::StatusCode::kInvalidArgument,
                HasSubstr("yaw"));
}

TEST(MapFiles, RefusesToWriteAMapWithoutCells) {
  EXPECT_STATUS(RenderFiles(FromOccupancyGrid({}), "x", {}), absl::StatusCode::kInvalidArgument, HasSubstr("no cells"));
}

TEST(MapFiles, NamesTheMissingOrSuperfluousFile) {
  const auto import = [](std::vector<MapFile> files) { return ImportFiles(files, MapDialect::kNav2); };
  constexpr auto kBad = absl::StatusCode::kInvalidArgument;
  EXPECT_STATUS(import({}), kBad, HasSubstr("the .yaml file is missing"));
  EXPECT_STATUS(import({{"room.yaml", kYaml}}), kBad, HasSubstr("the image is missing"));
  EXPECT_STATUS(import({{"room.pgm", kPgm}}), kBad, HasSubstr("the .yaml file is missing"));
  EXPECT_STATUS(import({{"a.yaml", kYaml}, {"b.yml", kYaml}}), kBad, HasSubstr("b.yml: one file too many"));
  EXPECT_STATUS(import({{"a.json", "{}"}, {"b.pgm", kPgm}}), kBad, HasSubstr("a.json: one file too many"));
  EXPECT_STATUS(import({{"room.yaml", kYaml}, {"room.pgm", kPgm}, {"c.png", ""}}), kBad,
                HasSubstr("c.png: one file too many"));
  EXPECT_STATUS(import({{"room.yaml", kYaml}, {"hall.pgm", kPgm}}), kBad, HasSubstr("its image is 'room.pgm'"));
  EXPECT_STATUS(import({{"room.yaml", "image: 3"}, {"room.pgm", kPgm}}), kBad, HasSubstr("room.yaml: "));
  EXPECT_STATUS(import({{"room.yaml", kYaml}, {"room.pgm", "P5\n3 2\n255\nab"}}), kBad,
                HasSubstr("room.pgm: the PGM file is truncated"));
  EXPECT_STATUS(import({{"room.yaml", kYaml}, {"room.pgm", "BM..."}}), kBad,
                HasSubstr("room.pgm: neither a PGM nor a PNG"));
  EXPECT_STATUS(import({{"room.yaml", kYaml}, {"room.pgm", "\x89PNG\r\n\x1a\n"}}), kBad,
                HasSubstr("room.pgm: cannot read the PNG"));
  EXPECT_STATUS(import({{"m.json", "{}"}}), kBad, HasSubstr("m.json: the JSON map has no 'xmin'"));
}

TEST(SafeStem, KeepsPlainNames) { EXPECT_EQ(SafeStem("Lab_2.floor-1"), "Lab_2.floor-1"); }

TEST(SafeStem, MakesAnyNameSafe) {
  EXPECT_EQ(SafeStem("../../etc/passwd"), "etc-passwd");
  EXPECT_EQ(SafeStem("it's \"here\"\n\0/"s), "it-s-here");
  EXPECT_EQ(SafeStem("B\xc3\xbcro 3: Flur"), "B-ro-3-Flur");
  EXPECT_EQ(SafeStem("-rf"), "rf");
  EXPECT_EQ(SafeStem(".hidden"), "hidden");
  EXPECT_EQ(SafeStem(""), "map");
  EXPECT_EQ(SafeStem("../.."), "map");
  EXPECT_EQ(SafeStem("\xe5\xbb\x8a\xe4\xb8\x8b"), "map");
  EXPECT_EQ(SafeStem(std::string(1000, 'a')), std::string(64, 'a'));
}

// Maps that people have made. The collection's file names are not always those in the YAML.
class RecordedMap : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(MapFiles, RecordedMap,
                         ::testing::Values("nav2/tb3_sandbox", "nav2/depot", "nav2/depot_keepout", "nav2/testmap",
                                           "nav2/warehouse", "sobi_cmg/cmg_imes_flur", "sobi_cmg/cmg_imes_flur_edit",
                                           "turtlebot3/map", "strands/UMA_236", "strands/UMA_236_237", "strands/g4s_y2",
                                           "strands/movecare_map", "acg/maps_blank_map",
                                           "acg/maps_blank_map_with_obstacle"));

TEST_P(RecordedMap, IsExportedByteForByte) {
  ENFILADE_RECORDING_OR_SKIP(yaml_path, std::string("maps/") + GetParam() + ".yaml");
  ENFILADE_RECORDING_OR_SKIP(pgm_path, std::string("maps/") + GetParam() + ".pgm");
  const std::string pgm = ReadBytes(pgm_path);
  const std::string yaml = ReadBytes(yaml_path);
  ASSERT_OK_AND_ASSIGN(const std::string image, ImageNameOf(yaml));
  ASSERT_OK_AND_ASSIGN(const ImportedMap map,
                       ImportFiles(std::vector<MapFile>{{"map.yaml", yaml}, {image, pgm}}, MapDialect::kNav2));
  ASSERT_OK_AND_ASSIGN(const auto files, RenderFiles(map.raster, "again", {}));
  EXPECT_TRUE(files[0].bytes == pgm) << "the PGM's bytes differ";
  ASSERT_OK_AND_ASSIGN(const ImportedMap again, ImportFiles(files, MapDialect::kNav2));
  EXPECT_TRUE(again.raster == map.raster) << "the raster differs the second time";
}

class RecordedPngMap : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(MapFiles, RecordedPngMap,
                         ::testing::Values("floor_0_routes", "floor_0_localization", "floor_1_routes",
                                           "floor_1_localization", "basement_routes", "basement_localization",
                                           "rooftop_routes", "rooftop_localization"));

TEST_P(RecordedPngMap, IsExportedWithTheSameGreys) {
  ENFILADE_RECORDING_OR_SKIP(yaml_path, std::string("maps/multimap_server/maps_") + GetParam() + ".yaml");
  ENFILADE_RECORDING_OR_SKIP(png_path, std::string("maps/multimap_server/maps_") + GetParam() + ".png");
  const std::string yaml = ReadBytes(yaml_path);
  ASSERT_OK_AND_ASSIGN(const std::string image, ImageNameOf(yaml));
  for (const MapDialect dialect : {MapDialect::kNav2, MapDialect::kRos1}) {
    ASSERT_OK_AND_ASSIGN(const ImportedMap map,
                         ImportFiles(std::vector<MapFile>{{"map.yaml", yaml}, {image, ReadBytes(png_path)}}, dialect));
    EXPECT_EQ(map.format, MapFileFormat::kPng);
    ASSERT_OK_AND_ASSIGN(const auto files, RenderFiles(map.raster, "again", {.format = MapFileFormat::kPng}));
    ASSERT_OK_AND_ASSIGN(const ImportedMap again, ImportFiles(files, dialect));
    EXPECT_TRUE(again.raster == map.raster) << "the raster differs the second time";
  }
}

TEST(RecordedMaps, LoadWithNav2sCounts) {
  // The corridor map holds 0, 205 and 254 only, which its YAML reads as occupied, unknown and free.
  ENFILADE_RECORDING_OR_SKIP(yaml_path, "maps/sobi_cmg/cmg_imes_flur.yaml");
  ENFILADE_RECORDING_OR_SKIP(pgm_path, "maps/sobi_cmg/cmg_imes_flur.pgm");
  const std::string pgm = ReadBytes(pgm_path);
  ASSERT_OK_AND_ASSIGN(const ImportedMap map,
                       ImportFiles(std::vector<MapFile>{{"m.yaml", ReadBytes(yaml_path)}, {"cmg_imes_flur.pgm", pgm}},
                                   MapDialect::kNav2));
  const OccupancyGrid grid = ToOccupancyGrid(map.raster);
  const std::string_view pixels = std::string_view(pgm).substr(pgm.size() - grid.cells.size());
  for (const auto& [grey, cell] : {std::pair{'\0', 255}, {'\xcd', 0}, {'\xfe', 1}}) {
    EXPECT_GT(std::count(pixels.begin(), pixels.end(), grey), 1000);
    EXPECT_EQ(std::count(grid.cells.begin(), grid.cells.end(), cell), std::count(pixels.begin(), pixels.end(), grey));
  }
}

}  // namespace
}  // namespace enfilade::grid
