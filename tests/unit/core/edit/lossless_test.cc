// SPDX-License-Identifier: Apache-2.0
// A map that was edited and edited back is the same file, to the byte; a stroke changes its own cells and no other.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <random>

#include "core/edit/apply.h"
#include "core/edit/history.h"
#include "core/grid/files/json_map.h"
#include "core/grid/files/map_files.h"
#include "core/grid/files/map_yaml.h"
#include "core/grid/files/png_codec.h"
#include "core/grid/tiled_raster.h"
#include "io/file.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"
#include "tests/unit/core/edit/edited_maps.h"

namespace enfilade::edit {
namespace {

using grid::ImportedMap;
using grid::MapFile;
using grid::MapRaster;
namespace fs = std::filesystem;

constexpr int kStrokes = 50;

// The map as a server keeps it.
struct StoredMap {
  grid::RasterHeader header;
  grid::TiledRaster tiles;

  MapRaster Raster() const {
    auto assembler = grid::RasterAssembler::Create(tiles.header);
    EXPECT_OK(assembler);
    for (const auto& [index, bytes] : tiles.tiles) EXPECT_OK(assembler->Add(index, bytes));
    return std::move(*assembler).Finish();
  }
};

StoredMap Stored(const MapRaster& raster) {
  StoredMap map{{}, grid::SplitIntoTiles(raster)};
  auto header = grid::DecodeRasterHeader(map.tiles.header);
  EXPECT_OK(header);
  map.header = *header;
  return map;
}

// Strokes across the map and beyond it, of what its form can say.
std::vector<KeptEdit> Strokes(const grid::RasterHeader& header, std::mt19937& random) {
  std::vector<Instruction> sayable = {Instruction::kClear};
  for (const Instruction instruction : {Instruction::kUnknown, Instruction::kFree, Instruction::kOccupied}) {
    if (CanSay(header, instruction).ok()) sayable.push_back(instruction);
  }
  const CellBox box = BoxOf(header);
  const auto near = [&](int first, int size) {
    return (first - 5 + static_cast<int>(random() % static_cast<std::uint32_t>(size + 10))) * kUnitsPerCell +
           static_cast<int>(random() % kUnitsPerCell);
  };
  std::vector<KeptEdit> edits;
  for (int i = 0; i < kStrokes; ++i) {
    Brush brush{{}, 128 + static_cast<int>(random() % 1'500)};
    for (std::uint32_t points = 1 + random() % 5; points > 0; --points) {
      brush.points.push_back({near(box.first_column, box.width), near(box.first_row, box.height)});
    }
    edits.push_back({std::to_string(i),
                     "ann",
                     i,
                     true,
                     LatticeOf(header),
                     {sayable[random() % sayable.size()], std::move(brush), false}});
  }
  return edits;
}

std::vector<MapFile> Exported(const MapRaster& raster, grid::MapFileFormat format) {
  auto files = grid::RenderFiles(raster, "map", {.format = format});
  EXPECT_OK(files);
  return files.ok() ? *std::move(files) : std::vector<MapFile>{};
}

bool AreSame(const std::vector<MapFile>& a, const std::vector<MapFile>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const MapFile& x, const MapFile& y) { return x.name == y.name && x.bytes == y.bytes; });
}

Overlay PublishedBy(const std::vector<KeptEdit>& edits, const Lattice& lattice) {
  return OverlayOf({{1, "", edits}}, lattice);
}

void ExpectLossless(const ImportedMap& map, std::uint32_t seed) {
  const StoredMap stored = Stored(map.raster);
  ASSERT_EQ(stored.Raster(), map.raster);
  const Lattice lattice = LatticeOf(stored.header);
  const grid::CellIndex min = stored.header.lattice_min;
  const std::vector<MapFile> files = Exported(map.raster, map.format);

  std::mt19937 random(seed);
  std::vector<KeptEdit> edits = Strokes(stored.header, random);
  const Overlay drawn = PublishedBy(edits, lattice);
  MapRaster edited = stored.Raster();
  ASSERT_OK(Apply(drawn, min, edited));
  ExpectExactlyApplied(map.raster, edited, drawn, min);

  std::shuffle(edits.begin(), edits.end(), random);
  for (KeptEdit& kept : edits) kept.active = false;
  const Overlay undone = PublishedBy(edits, lattice);
  ASSERT_TRUE(undone.empty());
  MapRaster restored = stored.Raster();
  ASSERT_OK(Apply(undone, min, restored));
  EXPECT_TRUE(AreSame(Exported(restored, map.format), files));

  KeptEdit& stroke = edits.front();
  stroke.active = true;
  const Overlay one = PublishedBy(edits, lattice);
  ASSERT_OK(Apply(one, min, restored));
  ExpectExactlyApplied(map.raster, restored, one, min);
}

struct Image {
  fs::path path;
  std::vector<MapFile> files;
  bool has_yaml = false;
};

// An image with the YAML file beside it, or else a usual one.
Image ReadImage(const fs::path& path) {
  Image image{path, {}, fs::exists(fs::path(path).replace_extension(".yaml"))};
  auto bytes = io::ReadFile(path);
  EXPECT_OK(bytes);
  if (image.has_yaml) {
    auto yaml = io::ReadFile(fs::path(path).replace_extension(".yaml"));
    EXPECT_OK(yaml);
    auto name = grid::ImageNameOf(*yaml);
    EXPECT_OK(name);
    image.files = {{"map.yaml", *yaml}, {fs::path(*name).filename().string(), *bytes}};
  } else {
    grid::MapYaml yaml{.image = path.filename().string(), .resolution = 0.05};
    image.files = {{"map.yaml", grid::FormatMapYaml(yaml)}, {path.filename().string(), *bytes}};
  }
  return image;
}

TEST(Lossless, MapsOfOthersAreTheSameFilesAfterUndo) {
  ENFILADE_RECORDING_OR_SKIP(folder, "maps");
  std::vector<fs::path> paths;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().extension() == ".pgm" || entry.path().extension() == ".png") paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  int maps = 0;
  int with_yaml = 0;
  for (const fs::path& path : paths) {
    SCOPED_TRACE(path.string());
    const Image image = ReadImage(path);
    const auto map = grid::ImportFiles(image.files, grid::MapDialect::kNav2);
    if (!map.ok()) {
      EXPECT_FALSE(image.has_yaml) << map.status();  // an image in colours, which is no map
      continue;
    }
    ExpectLossless(*map, static_cast<std::uint32_t>(maps));
    if (path.extension() == ".pgm") {
      EXPECT_TRUE(Exported(map->raster, map->format)[0].bytes == image.files[1].bytes);
    }
    ++maps;
    with_yaml += image.has_yaml ? 1 : 0;
    if (::testing::Test::HasFailure()) return;
  }
  RecordProperty("maps", maps);
  EXPECT_GE(with_yaml, 20);
  std::printf("%d maps, %d of them with a YAML file\n", maps, with_yaml);
}

// Files of a raster as other programs write them.
std::vector<MapFile> FilesOf(const MapRaster& form) {
  const grid::GridGeometry& geometry = form.geometry;
  if (const auto* const unit = std::get_if<grid::UnitCells>(&form.cells)) {
    return {{"m.json", grid::FormatJsonMap(unit->limits, std::span<const double>(unit->values))}};
  }
  const auto& grey = std::get<grid::GreyCells>(form.cells);
  grid::MapYaml yaml{.image = grey.alpha.empty() ? "m.pgm" : "m.png",
                     .resolution = geometry.resolution,
                     .origin = geometry.T_map_grid,
                     .interpretation = grey.interpretation};
  std::string image = fmt::format("P5\n# by hand\n{} {}\n{}\n", geometry.width, geometry.height, grey.max_value);
  if (grey.alpha.empty()) {
    image.append(grey.grey.begin(), grey.grey.end());
  } else {
    grid::PixelImage pixels{.width = geometry.width, .height = geometry.height, .channels = 2, .samples = {}};
    for (std::size_t i = 0; i < grey.grey.size(); ++i) {
      pixels.samples.insert(pixels.samples.end(), {grey.grey[i], grey.alpha[i]});
    }
    const auto png = grid::EncodePng(pixels);
    EXPECT_OK(png);
    image = *png;
  }
  return {{"m.yaml", grid::FormatMapYaml(yaml)}, {yaml.image, image}};
}

TEST(Lossless, GeneratedMapsOfEveryDialectAreTheSameFilesAfterUndo) {
  std::mt19937 random(14);
  int maps = 0;
  for (const MapRaster& form : EveryForm(random)) {
    if (std::holds_alternative<grid::OccupancyCells>(form.cells)) continue;
    SCOPED_TRACE(NameOf(form));
    const auto* const grey = std::get_if<grid::GreyCells>(&form.cells);
    const std::vector<MapFile> files = FilesOf(form);
    ASSERT_OK_AND_ASSIGN(const ImportedMap map, grid::ImportFiles(files, grey != nullptr ? grey->interpretation.dialect
                                                                                         : grid::MapDialect::kNav2));
    ExpectLossless(map, static_cast<std::uint32_t>(maps));
    if (map.format == grid::MapFileFormat::kPgm) {
      EXPECT_EQ(Exported(map.raster, map.format)[0].bytes, files[1].bytes);
    }
    if (::testing::Test::HasFailure()) return;
    ++maps;
  }
  EXPECT_GE(maps, 500);
}

}  // namespace
}  // namespace enfilade::edit
