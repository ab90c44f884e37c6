// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "absl/status/statusor.h"
#include "core/grid/files/map_files.h"

namespace enfilade::cli {

// The file and, for a YAML, the image that it names. NOT_FOUND; INVALID_ARGUMENT where the YAML names none.
absl::StatusOr<std::vector<grid::MapFile>> ReadMapFiles(const std::filesystem::path& path);

}  // namespace enfilade::cli
