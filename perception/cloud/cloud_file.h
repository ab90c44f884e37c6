// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "perception/cloud/cloud.h"

namespace enfilade::perception {

// Reads PCD 0.7 (ascii, binary, binary_compressed) or PLY 1.0 (ascii, binary_little_endian), told by its first line.
// Of each point x, y and z are taken, as float32 or float64; the other fields, and PCD's VIEWPOINT, are passed over.
// Points that are not finite are kept. INVALID_ARGUMENT: neither of the two, a header that is not understood, fewer
// points than it says, more than kMaxCloudPoints. An empty cloud is no error.
absl::StatusOr<Cloud> DecodeCloud(std::string_view bytes);
absl::StatusOr<Cloud> DecodePcd(std::string_view bytes);
absl::StatusOr<Cloud> DecodePly(std::string_view bytes);

// float32 x y z and nothing else (CloudEncoding::kXyz32).
absl::StatusOr<Cloud> DecodeXyz32(std::string_view bytes);

// PCD, binary.
std::string EncodePcd(const Cloud& cloud);

}  // namespace enfilade::perception
