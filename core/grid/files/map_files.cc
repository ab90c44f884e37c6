// SPDX-License-Identifier: Apache-2.0
#include "core/grid/files/map_files.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/files/grey_image.h"
#include "core/grid/files/json_map.h"
#include "core/grid/files/map_yaml.h"
#include "core/grid/files/pgm_codec.h"

namespace enfilade::grid {
namespace {

constexpr std::string_view kPngSignature = "\x89PNG";

std::string_view BaseName(std::string_view path) { return path.substr(path.find_last_of("/\\") + 1); }

std::string ExtensionOf(std::string_view name) {
  const std::string_view base = BaseName(name);
  const std::size_t point = base.rfind('.');
  std::string extension(point == std::string_view::npos ? "" : base.substr(point + 1));
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return extension;
}

// A raster's occupancy; no copy if the raster already holds it.
class OccupancyView {
 public:
  explicit OccupancyView(const MapRaster& raster) : own_(std::get_if<OccupancyCells>(&raster.cells)) {
    if (own_ == nullptr) converted_ = ToOccupancyGrid(raster).cells;
  }
  const std::vector<std::uint8_t>& cells() const { return own_ != nullptr ? own_->values : converted_; }

 private:
  const OccupancyCells* own_;
  std::vector<std::uint8_t> converted_;
};

absl::StatusOr<std::vector<MapFile>> RenderJson(const MapRaster& raster, const std::string& stem, double level) {
  std::vector<MapFile> files;
  if (const auto* const unit = std::get_if<UnitCells>(&raster.cells)) {
    files.push_back({stem + ".json", FormatJsonMap(unit->limits, unit->values)});
    return files;
  }
  ENFILADE_ASSIGN_OR_RETURN(const UnitLimits limits, UnitLimitsOf(raster.geometry, level));
  files.push_back({stem + ".json", FormatJsonMap(limits, OccupancyView(raster).cells())});
  return files;
}

absl::StatusOr<std::string> RenderImage(const GreyCells& cells, const GridGeometry& geometry, MapFileFormat format) {
  if (format == MapFileFormat::kPng) return EncodeGreyPng(cells, geometry.width, geometry.height);
  if (!cells.alpha.empty()) {
    return InvalidArgument(
        "the map has unknown cells, which a PGM cannot express in mode 'scale': export PNG, or mode 'trinary'");
  }
  return EncodePgm({.width = geometry.width,
                    .height = geometry.height,
                    .max_value = cells.max_value,
                    .header = cells.pgm_header,
                    .trailer = cells.pgm_trailer},
                   cells.grey);
}

absl::StatusOr<std::vector<MapFile>> RenderGrey(const GreyCells& cells, const GridGeometry& geometry,
                                                const std::string& stem, MapFileFormat format) {
  MapYaml yaml;
  yaml.image = stem + (format == MapFileFormat::kPng ? ".png" : ".pgm");
  yaml.resolution = geometry.resolution;
  yaml.origin = geometry.T_map_grid;
  yaml.interpretation = cells.interpretation;
  ENFILADE_ASSIGN_OR_RETURN(std::string image, RenderImage(cells, geometry, format));
  std::vector<MapFile> files;
  files.push_back({yaml.image, std::move(image)});
  files.push_back({stem + ".yaml", FormatMapYaml(yaml)});
  return files;
}

absl::StatusOr<ImportedMap> ImportJson(const MapFile& file) {
  ENFILADE_ASSIGN_OR_RETURN(ParsedJsonMap parsed, ParseJsonMap(file.bytes));
  return ImportedMap{std::move(parsed.raster), MapFileFormat::kJson, std::move(parsed.warnings)};
}

absl::Status ImportPgm(const MapFile& file, ImportedMap& map) {
  if (!file.bytes.starts_with('P')) return InvalidArgument("neither a PGM nor a PNG image: convert it to one of them");
  ENFILADE_ASSIGN_OR_RETURN(PgmImage image, DecodePgm(file.bytes));
  map.format = MapFileFormat::kPgm;
  map.raster.geometry.width = image.width;
  map.raster.geometry.height = image.height;
  map.raster.cells = GreyCells{.grey = std::move(image.pixels),
                               .max_value = image.max_value,
                               .pgm_header = std::move(image.header),
                               .pgm_trailer = std::move(image.trailer)};
  return absl::OkStatus();
}

absl::Status ImportPng(const MapFile& file, MapDialect dialect, ImportedMap& map) {
  ENFILADE_ASSIGN_OR_RETURN(GreyImage image, DecodeGreyPng(file.bytes, dialect));
  map.format = MapFileFormat::kPng;
  map.raster.geometry.width = image.width;
  map.raster.geometry.height = image.height;
  map.raster.cells = std::move(image.cells);
  map.warnings.insert(map.warnings.end(), image.warnings.begin(), image.warnings.end());
  return absl::OkStatus();
}

absl::StatusOr<ImportedMap> ImportImage(const MapFile& yaml_file, const MapFile& image_file, MapDialect dialect) {
  const absl::StatusOr<ParsedMapYaml> parsed = ParseMapYaml(yaml_file.bytes, dialect);
  if (!parsed.ok()) return WithContext(parsed.status(), yaml_file.name);
  const MapYaml& yaml = parsed->yaml;
  if (BaseName(yaml.image) != BaseName(image_file.name)) {
    return InvalidArgument("{}: its image is '{}', but the file given is '{}'", yaml_file.name, yaml.image,
                           image_file.name);
  }
  ImportedMap map;
  map.warnings = parsed->warnings;
  const bool is_png = image_file.bytes.starts_with(kPngSignature);
  if (const absl::Status status = is_png ? ImportPng(image_file, dialect, map) : ImportPgm(image_file, map);
      !status.ok()) {
    return WithContext(status, image_file.name);
  }
  map.raster.geometry.resolution = yaml.resolution;
  map.raster.geometry.T_map_grid = yaml.origin;
  std::get<GreyCells>(map.raster.cells).interpretation = yaml.interpretation;
  if (const absl::Status status = Validate(map.raster); !status.ok()) return WithContext(status, yaml_file.name);
  return map;
}

}  // namespace

absl::StatusOr<std::vector<MapFile>> RenderFiles(const MapRaster& raster, std::string_view name,
                                                 const MapFileOptions& options) {
  ENFILADE_RETURN_IF_ERROR(Validate(raster));
  ENFILADE_RETURN_IF_ERROR(options.save.Validate());
  const std::string stem = SafeStem(name);
  if (options.format == MapFileFormat::kJson) return RenderJson(raster, stem, options.json_level);
  const auto* const grey = std::get_if<GreyCells>(&raster.cells);
  if (grey != nullptr && (grey->alpha.empty() || options.format == MapFileFormat::kPng)) {
    return RenderGrey(*grey, raster.geometry, stem, options.format);
  }
  return RenderGrey(SaveAsGrey(OccupancyView(raster).cells(), options.save), raster.geometry, stem, options.format);
}

absl::StatusOr<ImportedMap> ImportFiles(std::span<const MapFile> files, MapDialect dialect) {
  const MapFile* yaml = nullptr;
  const MapFile* image = nullptr;
  for (const MapFile& file : files) {
    const std::string extension = ExtensionOf(file.name);
    if (extension == "json" && files.size() == 1) {
      absl::StatusOr<ImportedMap> map = ImportJson(file);
      if (!map.ok()) return WithContext(map.status(), file.name);
      return map;
    }
    const bool is_yaml = extension == "yaml" || extension == "yml";
    const MapFile*& place = is_yaml ? yaml : image;
    if (place != nullptr || extension == "json") {
      return InvalidArgument("{}: one file too many; a map is one .json, or one .yaml and its image", file.name);
    }
    place = &file;
  }
  if (yaml == nullptr || image == nullptr) {
    return InvalidArgument("{} is missing: a map is one .json, or one .yaml and its image",
                           yaml == nullptr ? "the .yaml file" : "the image");
  }
  return ImportImage(*yaml, *image, dialect);
}

absl::StatusOr<std::string> ImageNameOf(std::string_view yaml) {
  ENFILADE_ASSIGN_OR_RETURN(const ParsedMapYaml parsed, ParseMapYaml(yaml, MapDialect::kNav2));
  return parsed.yaml.image;
}

std::string SafeStem(std::string_view name) {
  constexpr std::size_t kMaxLength = 64;
  std::string stem;
  for (const char c : name) {
    const bool is_safe =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.' || c == '-';
    if (stem.size() == kMaxLength) break;
    if (is_safe) {
      stem += c;
    } else if (!stem.ends_with('-')) {
      stem += '-';
    }
  }
  const std::size_t begin = stem.find_first_not_of("-.");
  if (begin == std::string::npos) return "map";
  return stem.substr(begin, stem.find_last_not_of("-.") + 1 - begin);
}

}  // namespace enfilade::grid
