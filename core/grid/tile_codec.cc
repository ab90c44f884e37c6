// SPDX-License-Identifier: Apache-2.0
#include "core/grid/tile_codec.h"

#include <new>
#include <vector>

#include "core/base/error.h"
#include "core/compression/zstd_context.h"

namespace enfilade::grid {
namespace {

constexpr char kTileVersion = 1;
// Higher levels compress rasters little better; this one compresses several hundred MB/s.
constexpr int kTileCompressionLevel = 1;

}  // namespace

struct TilePacking::Contexts {
  ZstdCompressor compression{ZSTD_createCCtx()};
  ZstdDecompressor decompression{ZSTD_createDCtx()};
  std::vector<char> packed;
};

TilePacking::TilePacking() : contexts_(std::make_unique<Contexts>()) {
  ZSTD_CCtx_setParameter(contexts_->compression.get(), ZSTD_c_compressionLevel, kTileCompressionLevel);
  ZSTD_CCtx_setParameter(contexts_->compression.get(), ZSTD_c_checksumFlag, 1);
}
TilePacking::TilePacking(TilePacking&&) noexcept = default;
TilePacking::~TilePacking() = default;

std::string TilePacking::Pack(absl::Span<const std::uint8_t> content) {
  std::vector<char>& packed = contexts_->packed;
  packed.resize(1 + ZSTD_compressBound(content.size()));
  packed[0] = kTileVersion;
  const std::size_t size = ZSTD_compress2(contexts_->compression.get(), packed.data() + 1, packed.size() - 1,
                                          content.data(), content.size());
  // The output has room for the bound, so only memory can run out.
  if (ZSTD_isError(size) != 0) throw std::bad_alloc();
  return {packed.data(), size + 1};
}

absl::Status TilePacking::Unpack(std::string_view bytes, absl::Span<std::uint8_t> content) {
  if (bytes.empty()) return DataLoss("the tile is empty");
  if (bytes[0] > kTileVersion) {
    return FailedPrecondition("the tile was stored by a newer release (format {}, known up to {})", int{bytes[0]},
                              int{kTileVersion});
  }
  const std::size_t size = ZSTD_decompressDCtx(contexts_->decompression.get(), content.data(), content.size(),
                                               bytes.data() + 1, bytes.size() - 1);
  if (bytes[0] == kTileVersion && size == content.size()) return absl::OkStatus();
  return DataLoss("the tile is damaged: {}", ZSTD_isError(size) != 0 ? ZSTD_getErrorName(size) : "wrong size");
}

}  // namespace enfilade::grid
