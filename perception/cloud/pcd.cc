// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <cstring>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "perception/cloud/decode_cloud.h"
#include "perception/cloud/lzf.h"
#include "perception/cloud/point_fields.h"

namespace enfilade::perception {
namespace {

// Far more than any scanner's points have. With it the size of a cloud cannot overflow.
constexpr std::size_t kMaxPointBytes = std::size_t{1} << 24;

struct PcdHeader {
  std::vector<PointField> fields;
  std::size_t points = 0;
  std::string data;  // ascii, binary, binary_compressed
};

absl::Status ReadCounts(const std::vector<std::string_view>& words, std::size_t PointField::*member,
                        std::vector<PointField>& fields) {
  if (words.size() != fields.size() + 1) {
    return InvalidArgument("PCD: {} {} for {} fields", words.size() - 1, words[0], fields.size());
  }
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::optional<std::size_t> value = ParseCount(words[i + 1]);
    if (!value || *value == 0 || *value > 65536) return InvalidArgument("PCD: {} {}", words[0], words[i + 1]);
    fields[i].*member = *value;
  }
  return absl::OkStatus();
}

absl::Status ReadTypes(const std::vector<std::string_view>& words, std::vector<PointField>& fields) {
  if (words.size() != fields.size() + 1) {
    return InvalidArgument("PCD: {} TYPE for {} fields", words.size() - 1, fields.size());
  }
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (words[i + 1] == "F") {
      fields[i].kind = PointField::Kind::kFloat;
    } else if (words[i + 1] == "I") {
      fields[i].kind = PointField::Kind::kSigned;
    } else if (words[i + 1] == "U") {
      fields[i].kind = PointField::Kind::kUnsigned;
    } else {
      return InvalidArgument("PCD: TYPE {}: expected F, I or U", words[i + 1]);
    }
  }
  return absl::OkStatus();
}

// Reads the header and removes it from `bytes`.
absl::StatusOr<PcdHeader> ReadPcdHeader(std::string_view& bytes) {
  PcdHeader header;
  std::optional<std::size_t> points;
  std::size_t width = 0;
  std::size_t height = 1;
  while (header.data.empty()) {
    const std::optional<std::string_view> line = TakeLine(bytes);
    if (!line) return InvalidArgument("PCD: the header has no DATA line");
    const std::vector<std::string_view> words = Words(*line);
    if (words.empty() || words[0].front() == '#') continue;
    const std::string_view key = words[0];
    if (key == "FIELDS") {
      for (std::size_t i = 1; i < words.size(); ++i) header.fields.push_back({.name = std::string(words[i])});
    } else if (key == "SIZE") {
      ENFILADE_RETURN_IF_ERROR(ReadCounts(words, &PointField::size, header.fields));
    } else if (key == "COUNT") {
      ENFILADE_RETURN_IF_ERROR(ReadCounts(words, &PointField::count, header.fields));
    } else if (key == "TYPE") {
      ENFILADE_RETURN_IF_ERROR(ReadTypes(words, header.fields));
    } else if (key == "WIDTH" || key == "HEIGHT" || key == "POINTS") {
      const std::optional<std::size_t> value = words.size() == 2 ? ParseCount(words[1]) : std::nullopt;
      if (!value || *value > kMaxCloudPoints) {
        return InvalidArgument("PCD: \"{}\": expected a number up to {}", *line, kMaxCloudPoints);
      }
      if (key == "WIDTH") width = *value;
      if (key == "HEIGHT") height = *value;
      if (key == "POINTS") points = *value;
    } else if (key == "DATA") {
      if (words.size() != 2) return InvalidArgument("PCD: \"{}\"", *line);
      header.data = std::string(words[1]);
    } else if (key != "VERSION" && key != "VIEWPOINT") {
      return InvalidArgument("PCD: unknown header line \"{}\"", *line);
    }
  }
  header.points = points.value_or(width * height);
  if (header.points > kMaxCloudPoints) {
    return InvalidArgument("PCD: {} points, more than the limit of {}", header.points, kMaxCloudPoints);
  }
  return header;
}

absl::StatusOr<std::string> Unpack(std::string_view bytes, std::size_t expected) {
  std::uint32_t packed = 0;
  std::uint32_t unpacked = 0;
  if (bytes.size() < 8) return InvalidArgument("PCD: the packed data is missing");
  std::memcpy(&packed, bytes.data(), 4);
  std::memcpy(&unpacked, bytes.data() + 4, 4);
  if (bytes.size() - 8 < packed) {
    return InvalidArgument("PCD: truncated: {} of {} packed bytes", bytes.size() - 8, packed);
  }
  if (unpacked != expected) return InvalidArgument("PCD: {} unpacked bytes: expected {}", unpacked, expected);
  absl::StatusOr<std::string> data = UnpackLzf(bytes.substr(8, packed), unpacked);
  if (!data.ok()) return InvalidArgument("PCD: {}", std::string(data.status().message()));
  return data;
}

}  // namespace

absl::StatusOr<Cloud> DecodePcd(std::string_view bytes) {
  ENFILADE_ASSIGN_OR_RETURN(const PcdHeader header, ReadPcdHeader(bytes));
  ENFILADE_ASSIGN_OR_RETURN(const auto xyz, FindXyz(header.fields));
  if (PointSize(header.fields) > kMaxPointBytes) {
    return InvalidArgument("PCD: a point of {} bytes: expected at most {}", PointSize(header.fields), kMaxPointBytes);
  }
  const std::size_t expected = header.points * PointSize(header.fields);
  if (header.data == "ascii") return ReadText(bytes, header.points, header.fields, xyz);
  if (header.data == "binary") {
    if (bytes.size() < expected) return InvalidArgument("PCD: truncated: {} of {} bytes", bytes.size(), expected);
    return ReadRows(bytes, header.points, header.fields, xyz);
  }
  if (header.data == "binary_compressed") {
    if (header.points == 0) return Cloud{};
    ENFILADE_ASSIGN_OR_RETURN(const std::string data, Unpack(bytes, expected));
    return ReadColumns(data, header.points, header.fields, xyz);
  }
  return InvalidArgument("PCD: DATA {}: expected ascii, binary or binary_compressed", header.data);
}

}  // namespace enfilade::perception
