// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/sensor/record.h"

namespace enfilade::sources {

// The content of the file of an image or a point cloud. NOT_FOUND; INVALID_ARGUMENT: it is empty, not a regular file,
// or larger than kMaxBlobBytes.
absl::StatusOr<std::string> ReadContent(const std::filesystem::path& path);

// The reference by which a record names these bytes.
sensor::BlobRef RefOf(std::string_view content);

}  // namespace enfilade::sources
