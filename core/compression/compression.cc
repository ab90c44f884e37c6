// SPDX-License-Identifier: Apache-2.0
#include "core/compression/compression.h"

#include <zstd.h>

#include "core/base/error.h"

namespace enfilade {

std::string Compress(std::string_view bytes) {
  std::string compressed(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size = ZSTD_compress(compressed.data(), compressed.size(), bytes.data(), bytes.size(), 3);
  compressed.resize(ZSTD_isError(size) ? 0 : size);
  compressed.shrink_to_fit();  // kept as long as the map grows
  return compressed;
}

absl::StatusOr<std::string> Decompress(std::string_view compressed, std::size_t max_size) {
  const unsigned long long size = ZSTD_getFrameContentSize(compressed.data(), compressed.size());
  if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN || size > max_size) {
    return DataLoss("{} bytes are not compressed data of at most {} bytes", compressed.size(), max_size);
  }
  std::string bytes(size, '\0');
  const std::size_t done = ZSTD_decompress(bytes.data(), bytes.size(), compressed.data(), compressed.size());
  if (ZSTD_isError(done) || done != size) {
    return DataLoss("{} compressed bytes are damaged: {}", compressed.size(),
                    ZSTD_isError(done) ? ZSTD_getErrorName(done) : "too short");
  }
  return bytes;
}

}  // namespace enfilade
