// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace enfilade {

// zstd. Deterministic.
std::string Compress(std::string_view bytes);

// DATA_LOSS if `compressed` is not the result of Compress or claims to hold more than `max_size` bytes.
absl::StatusOr<std::string> Decompress(std::string_view compressed, std::size_t max_size);

}  // namespace enfilade
