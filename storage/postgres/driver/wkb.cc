// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/driver/wkb.h"

#include <cstdint>

#include "core/base/binary.h"
#include "core/base/error.h"

namespace enfilade::storage::postgres {
namespace {

constexpr std::uint8_t kLittleEndian = 1;
constexpr std::uint32_t kPolygon = 3;

}  // namespace

std::string EncodePolygon(const std::vector<Eigen::Vector2d>& corners) {
  std::string bytes;
  if (corners.empty()) return bytes;
  BinaryWriter writer(bytes);
  writer.Put(kLittleEndian);
  writer.Put(kPolygon);
  writer.Put<std::uint32_t>(1);  // rings
  writer.Put(static_cast<std::uint32_t>(corners.size() + 1));
  for (const Eigen::Vector2d& corner : corners) {
    writer.Put(corner.x());
    writer.Put(corner.y());
  }
  writer.Put(corners.front().x());
  writer.Put(corners.front().y());
  return bytes;
}

absl::StatusOr<std::vector<Eigen::Vector2d>> DecodePolygon(std::string_view bytes) {
  BinaryReader reader(bytes);
  const auto order = reader.Get<std::uint8_t>();
  const auto type = reader.Get<std::uint32_t>();
  const auto rings = reader.Get<std::uint32_t>();
  const auto points = reader.Get<std::uint32_t>();
  if (!reader.ok() || order != kLittleEndian || type != kPolygon || rings < 1 || points < 2 ||
      points > reader.remaining() / (2 * sizeof(double))) {
    return DataLoss("{} bytes are not a polygon", bytes.size());
  }
  std::vector<Eigen::Vector2d> corners(points - 1);
  for (Eigen::Vector2d& corner : corners) {
    corner.x() = reader.Get<double>();
    corner.y() = reader.Get<double>();
  }
  return corners;
}

}  // namespace enfilade::storage::postgres
