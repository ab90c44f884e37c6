// SPDX-License-Identifier: Apache-2.0
#include "core/grid/raster_header.h"

#include "core/base/binary.h"
#include "core/base/error.h"
#include "core/grid/occupancy_values.h"

namespace enfilade::grid {
namespace {

constexpr std::uint32_t kMagic = 0x52464E45;  // "ENFR"
constexpr std::uint8_t kHeaderVersion = 1;
enum class Encoding : std::uint8_t { kOccupancy = 0, kGrey = 1, kUnit = 2 };

void Write(const OccupancyCells&, bool, BinaryWriter& writer) { writer.Put(Encoding::kOccupancy); }

void Write(const GreyCells& cells, bool has_alpha, BinaryWriter& writer) {
  writer.Put(Encoding::kGrey);
  writer.Put<std::uint8_t>(has_alpha ? 1 : 0);
  writer.Put(static_cast<std::uint8_t>(cells.max_value));
  writer.Put(cells.interpretation.mode);
  writer.Put(cells.interpretation.dialect);
  writer.Put<std::uint8_t>(cells.interpretation.negate ? 1 : 0);
  writer.Put(cells.interpretation.occupied_thresh);
  writer.Put(cells.interpretation.free_thresh);
  writer.PutString(cells.pgm_header);
  writer.PutString(cells.pgm_trailer);
}

void Write(const UnitCells& cells, bool, BinaryWriter& writer) {
  writer.Put(Encoding::kUnit);
  const UnitLimits& limits = cells.limits;
  for (const double value :
       {limits.xmin, limits.xmax, limits.ymin, limits.ymax, limits.stepx, limits.stepy, limits.level}) {
    writer.Put(value);
  }
}

GreyCells ReadGrey(BinaryReader& reader, bool& has_alpha) {
  GreyCells cells;
  has_alpha = reader.Get<std::uint8_t>() != 0;
  cells.max_value = reader.Get<std::uint8_t>();
  cells.interpretation.mode = reader.Get<MapMode>();
  cells.interpretation.dialect = reader.Get<MapDialect>();
  cells.interpretation.negate = reader.Get<std::uint8_t>() != 0;
  cells.interpretation.occupied_thresh = reader.Get<double>();
  cells.interpretation.free_thresh = reader.Get<double>();
  cells.pgm_header = reader.GetString();
  cells.pgm_trailer = reader.GetString();
  return cells;
}

UnitCells ReadUnit(BinaryReader& reader) {
  UnitCells cells;
  UnitLimits& limits = cells.limits;
  for (double* const value :
       {&limits.xmin, &limits.xmax, &limits.ymin, &limits.ymax, &limits.stepx, &limits.stepy, &limits.level}) {
    *value = reader.Get<double>();
  }
  return cells;
}

GridGeometry ReadGeometry(BinaryReader& reader) {
  GridGeometry geometry;
  geometry.resolution = reader.Get<double>();
  geometry.T_map_grid.x = reader.Get<double>();
  geometry.T_map_grid.y = reader.Get<double>();
  geometry.T_map_grid.yaw = reader.Get<double>();
  geometry.width = reader.Get<std::int32_t>();
  geometry.height = reader.Get<std::int32_t>();
  return geometry;
}

bool IsValid(const RasterHeader& header) {
  constexpr int kLatticeLimit = 1 << 30;
  const CellIndex min = header.lattice_min;
  if (min.column < -kLatticeLimit || min.column > kLatticeLimit || min.row < -kLatticeLimit ||
      min.row > kLatticeLimit) {
    return false;
  }
  const auto* const grey = std::get_if<GreyCells>(&header.raster.cells);
  return grey == nullptr || (grey->max_value >= 1 && grey->interpretation.mode <= MapMode::kRaw &&
                             grey->interpretation.dialect <= MapDialect::kRos1);
}

// Raster: MapRaster, const or not; Byte accordingly.
template <typename Byte, typename Raster>
std::vector<CellPlane<Byte>> Planes(Raster& raster, std::uint8_t background) {
  if (auto* const occupancy = std::get_if<OccupancyCells>(&raster.cells)) {
    return {{occupancy->values.data(), 1, background}};
  }
  if (auto* const unit = std::get_if<UnitCells>(&raster.cells)) {
    return {{reinterpret_cast<Byte*>(unit->values.data()), sizeof(double), 0}};
  }
  auto& grey = std::get<GreyCells>(raster.cells);
  std::vector<CellPlane<Byte>> planes = {{grey.grey.data(), 1, background}};
  if (!grey.alpha.empty()) planes.push_back({grey.alpha.data(), 1, kOpaqueAlpha});
  return planes;
}

}  // namespace

std::string EncodeRasterHeader(const RasterHeader& header) {
  std::string bytes;
  BinaryWriter writer(bytes);
  writer.Put(kMagic);
  writer.Put(kHeaderVersion);
  const GridGeometry& geometry = header.raster.geometry;
  writer.Put(geometry.resolution);
  writer.Put(geometry.T_map_grid.x);
  writer.Put(geometry.T_map_grid.y);
  writer.Put(geometry.T_map_grid.yaw);
  writer.Put<std::int32_t>(geometry.width);
  writer.Put<std::int32_t>(geometry.height);
  writer.Put<std::int32_t>(header.lattice_min.column);
  writer.Put<std::int32_t>(header.lattice_min.row);
  writer.Put(header.background);
  std::visit([&](const auto& cells) { Write(cells, header.has_alpha, writer); }, header.raster.cells);
  return bytes;
}

absl::StatusOr<RasterHeader> DecodeRasterHeader(std::string_view bytes) {
  BinaryReader reader(bytes);
  if (reader.Get<std::uint32_t>() != kMagic) return DataLoss("the bytes are not a raster's header");
  const auto version = reader.Get<std::uint8_t>();
  if (version > kHeaderVersion) {
    return FailedPrecondition("the raster was stored by a newer release (format {}, known up to {})", version,
                              kHeaderVersion);
  }
  RasterHeader header;
  header.raster.geometry = ReadGeometry(reader);
  header.lattice_min.column = reader.Get<std::int32_t>();
  header.lattice_min.row = reader.Get<std::int32_t>();
  header.background = reader.Get<std::uint8_t>();
  switch (reader.Get<Encoding>()) {
    case Encoding::kOccupancy:
      break;
    case Encoding::kGrey:
      header.raster.cells = ReadGrey(reader, header.has_alpha);
      break;
    case Encoding::kUnit:
      header.raster.cells = ReadUnit(reader);
      break;
    default:
      return DataLoss("the raster's header names an unknown kind of cells");
  }
  if (version == 0 || !reader.at_end() || !IsValid(header)) return DataLoss("the raster's header is damaged");
  if (const absl::Status status = Validate(header.raster.geometry); !status.ok()) {
    return DataLoss("the raster's header is damaged: {}",
                    std::string(status.message().data(), status.message().size()));
  }
  return header;
}

std::vector<CellPlane<std::uint8_t>> PlanesOf(MapRaster& raster, std::uint8_t background) {
  return Planes<std::uint8_t>(raster, background);
}

std::vector<CellPlane<const std::uint8_t>> PlanesOf(const MapRaster& raster, std::uint8_t background) {
  return Planes<const std::uint8_t>(raster, background);
}

}  // namespace enfilade::grid
