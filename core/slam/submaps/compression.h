// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace enfilade::slam {

// zstd, level 3: the same bytes in give the same bytes out.
std::string Compress(std::string_view bytes);

// DATA_LOSS where `compressed` is not what Compress made or says that it holds more than `max_size` bytes.
absl::StatusOr<std::string> Decompress(std::string_view compressed, std::size_t max_size);

}  // namespace enfilade::slam
