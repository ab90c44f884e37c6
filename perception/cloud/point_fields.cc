// SPDX-License-Identifier: Apache-2.0
#include "perception/cloud/point_fields.h"

#include <charconv>
#include <cstdint>
#include <cstring>
#include <limits>

#include "core/base/error.h"

namespace enfilade::perception {
namespace {

float ReadFloat(const char* at, std::size_t size) {
  if (size == sizeof(double)) {
    double value = 0.0;
    std::memcpy(&value, at, sizeof value);
    return static_cast<float>(value);
  }
  float value = 0.0F;
  std::memcpy(&value, at, sizeof value);
  return value;
}

std::size_t BytesOf(const PointField& field) { return field.size * field.count; }

std::optional<float> ParseFloat(std::string_view word) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  float value = 0.0F;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size()) return std::nullopt;
  if (error == std::errc::result_out_of_range) return std::numeric_limits<float>::quiet_NaN();
  if (error != std::errc()) return std::nullopt;
  return value;
}

}  // namespace

absl::StatusOr<std::array<std::size_t, 3>> FindXyz(const std::vector<PointField>& fields) {
  std::array<std::size_t, 3> xyz{};
  const std::array<std::string_view, 3> names = {"x", "y", "z"};
  for (std::size_t k = 0; k < names.size(); ++k) {
    std::size_t i = 0;
    while (i < fields.size() && fields[i].name != names[k]) ++i;
    if (i == fields.size()) return InvalidArgument("the cloud has no field {}", names[k]);
    if (fields[i].kind != PointField::Kind::kFloat || (fields[i].size != 4 && fields[i].size != 8) ||
        fields[i].count != 1) {
      return InvalidArgument("the cloud's field {} is no single float of 4 or 8 bytes", names[k]);
    }
    xyz[k] = i;
  }
  return xyz;
}

std::size_t PointSize(const std::vector<PointField>& fields) {
  std::size_t size = 0;
  for (const PointField& field : fields) size += BytesOf(field);
  return size;
}

Cloud ReadRows(std::string_view bytes, std::size_t count, const std::vector<PointField>& fields,
               const std::array<std::size_t, 3>& xyz) {
  std::vector<std::size_t> offsets;
  std::size_t stride = 0;
  for (const PointField& field : fields) {
    offsets.push_back(stride);
    stride += BytesOf(field);
  }
  Cloud cloud;
  cloud.points.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      cloud.points[i][static_cast<Eigen::Index>(k)] =
          ReadFloat(bytes.data() + i * stride + offsets[xyz[k]], fields[xyz[k]].size);
    }
  }
  return cloud;
}

Cloud ReadColumns(std::string_view bytes, std::size_t count, const std::vector<PointField>& fields,
                  const std::array<std::size_t, 3>& xyz) {
  Cloud cloud;
  cloud.points.resize(count);
  std::size_t offset = 0;
  for (std::size_t field = 0; field < fields.size(); ++field) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (xyz[k] != field) continue;
      for (std::size_t i = 0; i < count; ++i) {
        cloud.points[i][static_cast<Eigen::Index>(k)] =
            ReadFloat(bytes.data() + offset + i * fields[field].size, fields[field].size);
      }
    }
    offset += BytesOf(fields[field]) * count;
  }
  return cloud;
}

absl::StatusOr<Cloud> ReadText(std::string_view text, std::size_t count, const std::vector<PointField>& fields,
                               const std::array<std::size_t, 3>& xyz) {
  std::array<std::size_t, 3> words{};
  std::size_t width = 0;
  for (std::size_t field = 0; field < fields.size(); ++field) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (xyz[k] == field) words[k] = width;
    }
    width += fields[field].count;
  }
  Cloud cloud;
  while (cloud.points.size() < count) {
    const std::optional<std::string_view> line = TakeLine(text);
    if (!line) return InvalidArgument("the cloud ends after {} of {} points", cloud.points.size(), count);
    const std::vector<std::string_view> numbers = Words(*line);
    if (numbers.empty()) continue;
    Eigen::Vector3f point;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::optional<float> value = numbers.size() < width ? std::nullopt : ParseFloat(numbers[words[k]]);
      if (!value) return InvalidArgument("point {} of the cloud cannot be read: \"{}\"", cloud.points.size(), *line);
      point[static_cast<Eigen::Index>(k)] = *value;
    }
    cloud.points.push_back(point);
  }
  return cloud;
}

std::optional<std::string_view> TakeLine(std::string_view& text) {
  if (text.empty()) return std::nullopt;
  const std::size_t end = text.find('\n');
  std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

std::vector<std::string_view> Words(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t position = line.find_first_not_of(" \t"); position != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(" \t", position), line.size());
    words.push_back(line.substr(position, end - position));
    position = line.find_first_not_of(" \t", end);
  }
  return words;
}

std::optional<std::size_t> ParseCount(std::string_view word) {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

}  // namespace enfilade::perception
