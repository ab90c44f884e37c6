// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace enfilade::perception {

// Unpacks LZF (Lehmann's liblzf format, as PCD's binary_compressed uses it) into exactly `size` bytes. DATA_LOSS where
// the packed bytes give more, fewer, or refer before their beginning.
absl::StatusOr<std::string> UnpackLzf(std::string_view packed, std::size_t size);

}  // namespace enfilade::perception
