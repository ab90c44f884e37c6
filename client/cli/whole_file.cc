// SPDX-License-Identifier: Apache-2.0
#include "client/cli/whole_file.h"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

#include "core/base/error.h"

namespace enfilade::cli {

absl::StatusOr<std::string> ReadWholeFile(const std::string& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) return NotFound("{}: no such file", path);
  if (status.type() == std::filesystem::file_type::directory) return InvalidArgument("{}: is a folder", path);
  std::ifstream file(path, std::ios::binary);
  std::stringstream bytes;
  if (file && file.peek() != std::ifstream::traits_type::eof()) bytes << file.rdbuf();  // nothing put sets failbit
  if (file.bad() || !file.is_open()) return InvalidArgument("{}: cannot be read", path);
  return std::move(bytes).str();
}

absl::Status WriteWholeFile(const std::string& path, std::string_view bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << bytes;
  file.close();
  if (file) return absl::OkStatus();
  return FailedPrecondition("{}: cannot be written (no such folder, no permission, or the disk is full)", path);
}

}  // namespace enfilade::cli
