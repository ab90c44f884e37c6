// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "perception/cloud/cloud.h"

namespace enfilade::perception {

// Reads PCD 0.7 (ascii, binary, binary_compressed) or PLY 1.0 (ascii, binary_little_endian), distinguished by the first
// line. Takes x, y and z of each point, float32 or float64; ignores other fields and PCD's VIEWPOINT. Points that are
// not finite are kept. INVALID_ARGUMENT: another format, an unknown header line, fewer points than announced, more than
// kMaxCloudPoints. An empty cloud is valid.
absl::StatusOr<Cloud> DecodeCloud(std::string_view bytes);
absl::StatusOr<Cloud> DecodePcd(std::string_view bytes);
absl::StatusOr<Cloud> DecodePly(std::string_view bytes);

// Reads bare float32 x y z (CloudEncoding::kXyz32).
absl::StatusOr<Cloud> DecodeXyz32(std::string_view bytes);

}  // namespace enfilade::perception
