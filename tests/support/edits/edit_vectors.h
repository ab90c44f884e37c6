// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/edit/map_edit.h"
#include "core/grid/tiled_raster.h"
#include "enfilade/v1/map_edit.pb.h"

namespace enfilade::testing {

// A file of tests/data/edits, whose README.md describes it.
struct EditVectors {
  struct Tile {
    std::string sha256;  // 32 bytes
    std::int64_t cells = 0;

    friend bool operator==(const Tile&, const Tile&) = default;
  };
  std::vector<v1::MapEdit> edits;
  std::map<grid::TileIndex, Tile> tiles;
};

std::vector<std::filesystem::path> EditVectorFiles();
// INVALID_ARGUMENT naming the file and what is wrong.
absl::StatusOr<EditVectors> ReadEditVectors(const std::filesystem::path& path);

// Of an edit that is no fill, field by field, unchecked.
edit::MapEdit ToCoreEdit(const v1::MapEdit& edit);

}  // namespace enfilade::testing
