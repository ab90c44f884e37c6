// SPDX-License-Identifier: Apache-2.0
#include "client/sources/content.h"

#include <system_error>

#include "core/base/error.h"
#include "core/base/sha256.h"
#include "io/file.h"

namespace enfilade::sources {

namespace fs = std::filesystem;

absl::StatusOr<std::string> ReadContent(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) return NotFound("{}: no such file", path.string());
  if (status.type() != fs::file_type::regular) return InvalidArgument("{}: not a regular file", path.string());
  const auto size = fs::file_size(path, error);
  if (error) return InvalidArgument("{}: {}", path.string(), error.message());
  if (size < 1 || size > static_cast<std::uintmax_t>(sensor::kMaxBlobBytes)) {
    return InvalidArgument("{}: {} bytes: expected 1 to {}", path.string(), size, sensor::kMaxBlobBytes);
  }
  return io::ReadFile(path);
}

sensor::BlobRef RefOf(std::string_view content) { return {Sha256(content), static_cast<std::int64_t>(content.size())}; }

}  // namespace enfilade::sources
