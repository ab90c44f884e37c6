// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace enfilade::io {

// Whole files. Both functions block; both work on anything that can be opened: regular files, pipes, /dev/stdin. Error
// messages begin with the path. Other errors of the system than those named are INTERNAL.

// The bytes of a file. NOT_FOUND: no such file; INVALID_ARGUMENT: a folder; PERMISSION_DENIED.
absl::StatusOr<std::string> ReadFile(const std::filesystem::path& path);

// Creates the file, or replaces its content. FAILED_PRECONDITION: its folder does not exist; INVALID_ARGUMENT: a
// folder; PERMISSION_DENIED; RESOURCE_EXHAUSTED: the disk or the quota is full. Not atomic: after an error, or for a
// concurrent reader, the file may hold a part of the bytes.
absl::Status WriteFile(const std::filesystem::path& path, std::string_view bytes);

// The status of a failed call of the system: `error` is its errno, `what` it did not do ("cannot be read"). The codes
// are those of ReadFile.
absl::Status FileError(const std::filesystem::path& path, std::string_view what, int error);

}  // namespace enfilade::io
