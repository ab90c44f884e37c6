// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "absl/status/statusor.h"
#include "core/grid/files/map_files.h"

namespace enfilade::cli {

// A map's JSON file, or its YAML file and the image that this names. NOT_FOUND; INVALID_ARGUMENT: the YAML names no
// image.
absl::StatusOr<std::vector<grid::MapFile>> ReadMapFiles(const std::filesystem::path& path);

}  // namespace enfilade::cli
