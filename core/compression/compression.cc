// SPDX-License-Identifier: Apache-2.0
#include "core/compression/compression.h"

#include <memory>

#include "core/base/error.h"
#include "core/compression/zstd_context.h"

namespace enfilade {
namespace {

// Level 3 makes submaps 3 % smaller, and takes longer.
constexpr int kLevel = 1;

// Their tables are larger than most of what is compressed, so each thread keeps its own.
ZSTD_CCtx* CompressionContext() {
  thread_local const ZstdCompressor context(ZSTD_createCCtx());
  return context.get();
}

ZSTD_DCtx* DecompressionContext() {
  thread_local const ZstdDecompressor context(ZSTD_createDCtx());
  return context.get();
}

}  // namespace

std::string Compress(std::string_view bytes) {
  const std::size_t bound = ZSTD_compressBound(bytes.size());
  const auto compressed = std::make_unique_for_overwrite<char[]>(bound);
  const std::size_t size =
      ZSTD_compressCCtx(CompressionContext(), compressed.get(), bound, bytes.data(), bytes.size(), kLevel);
  return {compressed.get(), ZSTD_isError(size) ? 0 : size};
}

absl::StatusOr<std::string> Decompress(std::string_view compressed, std::size_t max_size) {
  const unsigned long long size = ZSTD_getFrameContentSize(compressed.data(), compressed.size());
  if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN || size > max_size) {
    return DataLoss("{} bytes are not compressed data of at most {} bytes", compressed.size(), max_size);
  }
  std::string bytes(size, '\0');
  const std::size_t done =
      ZSTD_decompressDCtx(DecompressionContext(), bytes.data(), bytes.size(), compressed.data(), compressed.size());
  if (ZSTD_isError(done) || done != size) {
    return DataLoss("{} compressed bytes are damaged: {}", compressed.size(),
                    ZSTD_isError(done) ? ZSTD_getErrorName(done) : "too short");
  }
  return bytes;
}

}  // namespace enfilade
