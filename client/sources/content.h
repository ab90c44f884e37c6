// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/sensor/record.h"

namespace enfilade::sources {

// The whole content of a file of an image or a point cloud. NOT_FOUND, or INVALID_ARGUMENT where it is empty, no
// regular file, or larger than kMaxBlobBytes.
absl::StatusOr<std::string> ReadContent(const std::filesystem::path& path);

// How a record refers to these bytes.
sensor::BlobRef RefOf(std::string_view content);

}  // namespace enfilade::sources
