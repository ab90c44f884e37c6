// SPDX-License-Identifier: Apache-2.0
#include "core/base/binary.h"
#include "core/base/error.h"
#include "core/edit/map_edit.h"

namespace enfilade::edit {
namespace {

constexpr std::uint8_t kShapeVersion = 1;
enum class Kind : std::uint8_t { kBrush = 1, kLine = 2, kPolygon = 3, kPatch = 4 };

void PutPoints(const std::vector<LatticePoint>& points, BinaryWriter& writer) {
  writer.Put(static_cast<std::uint32_t>(points.size()));
  for (const LatticePoint& point : points) {
    writer.Put(point.x);
    writer.Put(point.y);
  }
}

std::vector<LatticePoint> GetPoints(BinaryReader& reader) {
  const auto count = reader.Get<std::uint32_t>();
  std::vector<LatticePoint> points;
  for (std::uint32_t i = 0; i < count && reader.ok(); ++i) {
    const auto x = reader.Get<std::int32_t>();
    points.push_back({x, reader.Get<std::int32_t>()});
  }
  return points;
}

void Put(const Brush& brush, BinaryWriter& writer) {
  writer.Put(Kind::kBrush);
  writer.Put(brush.radius);
  PutPoints(brush.points, writer);
}
void Put(const Line& line, BinaryWriter& writer) {
  writer.Put(Kind::kLine);
  PutPoints(line.points, writer);
}
void Put(const Polygon& polygon, BinaryWriter& writer) {
  writer.Put(Kind::kPolygon);
  writer.Put(static_cast<std::uint32_t>(polygon.rings.size()));
  for (const auto& ring : polygon.rings) PutPoints(ring, writer);
}
void Put(const Patch& patch, BinaryWriter& writer) {
  writer.Put(Kind::kPatch);
  for (const int value : {patch.box.first_column, patch.box.first_row, patch.box.width, patch.box.height}) {
    writer.Put(static_cast<std::int32_t>(value));
  }
  writer.PutVector(patch.runs);
}

Polygon GetPolygon(BinaryReader& reader) {
  Polygon polygon;
  const auto rings = reader.Get<std::uint32_t>();
  for (std::uint32_t i = 0; i < rings && reader.ok(); ++i) polygon.rings.push_back(GetPoints(reader));
  return polygon;
}
Patch GetPatch(BinaryReader& reader) {
  Patch patch;
  for (int* const value : {&patch.box.first_column, &patch.box.first_row, &patch.box.width, &patch.box.height}) {
    *value = reader.Get<std::int32_t>();
  }
  patch.runs = reader.GetVector<std::uint32_t>();
  return patch;
}

}  // namespace

std::string Encode(const Shape& shape) {
  std::string bytes;
  BinaryWriter writer(bytes);
  writer.Put(kShapeVersion);
  std::visit([&](const auto& kind) { Put(kind, writer); }, shape);
  return bytes;
}

absl::StatusOr<Shape> DecodeShape(std::string_view bytes) {
  BinaryReader reader(bytes);
  const auto version = reader.Get<std::uint8_t>();
  if (version < kShapeVersion) return DataLoss("an edit's shape is damaged");
  if (version > kShapeVersion) return FailedPrecondition("an edit has format {}: a newer program stored it", version);
  Shape shape;
  switch (reader.Get<Kind>()) {
    case Kind::kBrush: {
      const auto radius = reader.Get<std::int32_t>();
      shape = Brush{GetPoints(reader), radius};
      break;
    }
    case Kind::kLine:
      shape = Line{GetPoints(reader)};
      break;
    case Kind::kPolygon:
      shape = GetPolygon(reader);
      break;
    case Kind::kPatch:
      shape = GetPatch(reader);
      break;
    default:
      return DataLoss("an edit's shape is damaged");
  }
  if (!reader.at_end()) return DataLoss("an edit's shape is damaged");
  if (const absl::Status valid = ValidateForm(shape); !valid.ok()) {
    return DataLoss("an edit's shape is damaged: {}", std::string(valid.message()));
  }
  return shape;
}

}  // namespace enfilade::edit
