// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace enfilade::cli {

// The bytes of a file. NOT_FOUND: no such file; INVALID_ARGUMENT: a folder, or it cannot be read.
absl::StatusOr<std::string> ReadWholeFile(const std::string& path);

// Replaces the file. FAILED_PRECONDITION where it cannot be written.
absl::Status WriteWholeFile(const std::string& path, std::string_view bytes);

}  // namespace enfilade::cli
