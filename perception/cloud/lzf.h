// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace enfilade::perception {

// Decompresses LZF (liblzf's format, used by PCD's binary_compressed) into exactly `size` bytes. DATA_LOSS: more or
// fewer bytes, truncated input, or a reference before the start.
absl::StatusOr<std::string> UnpackLzf(std::string_view packed, std::size_t size);

}  // namespace enfilade::perception
