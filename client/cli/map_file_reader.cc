// SPDX-License-Identifier: Apache-2.0
#include "client/cli/map_file_reader.h"

#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "io/file.h"

namespace enfilade::cli {
namespace {

absl::StatusOr<grid::MapFile> ReadMapFile(const std::filesystem::path& path) {
  ENFILADE_ASSIGN_OR_RETURN(std::string bytes, io::ReadFile(path));
  return grid::MapFile{path.filename().string(), std::move(bytes)};
}

}  // namespace

absl::StatusOr<std::vector<grid::MapFile>> ReadMapFiles(const std::filesystem::path& path) {
  std::vector<grid::MapFile> files;
  ENFILADE_ASSIGN_OR_RETURN(grid::MapFile first, ReadMapFile(path));
  files.push_back(std::move(first));
  if (path.extension() == ".json") return files;
  const auto image = grid::ImageNameOf(files.front().bytes);
  if (!image.ok()) return WithContext(image.status(), path.string());
  ENFILADE_ASSIGN_OR_RETURN(grid::MapFile second, ReadMapFile(path.parent_path() / *image));
  files.push_back(std::move(second));
  return files;
}

}  // namespace enfilade::cli
