// SPDX-License-Identifier: Apache-2.0
#include "perception/cloud/decode_cloud.h"

#include "core/base/error.h"
#include "perception/cloud/point_fields.h"

namespace enfilade::perception {

absl::StatusOr<Cloud> DecodeCloud(std::string_view bytes) {
  if (bytes.empty()) return InvalidArgument("the cloud is empty (0 bytes)");
  std::string_view rest = bytes;
  const std::string_view first = TakeLine(rest).value_or("").substr(0, 64);
  if (first == "ply") return DecodePly(bytes);
  if (first.substr(0, 1) == "#" || first.substr(0, 7) == "VERSION" || first.substr(0, 6) == "FIELDS") {
    return DecodePcd(bytes);
  }
  return InvalidArgument("the cloud is neither PCD nor PLY ({} bytes)", bytes.size());
}

absl::StatusOr<Cloud> DecodeXyz32(std::string_view bytes) {
  const std::vector<PointField> fields = {{.name = "x"}, {.name = "y"}, {.name = "z"}};
  const std::size_t size = PointSize(fields);
  if (bytes.size() % size != 0) return InvalidArgument("a cloud of {} bytes: expected 12 for each point", bytes.size());
  if (bytes.size() / size > kMaxCloudPoints) {
    return InvalidArgument("the cloud has {} points, more than the limit of {}", bytes.size() / size, kMaxCloudPoints);
  }
  return ReadRows(bytes, bytes.size() / size, fields, {0, 1, 2});
}

}  // namespace enfilade::perception
