// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/types/span.h"

namespace enfilade::grid {

// The bytes of one tile: one byte format version (1), then one Zstandard frame with checksum. Not thread-safe.
class TilePacking {
 public:
  TilePacking();
  TilePacking(TilePacking&&) noexcept;
  ~TilePacking();

  std::string Pack(absl::Span<const std::uint8_t> content);
  // Fills `content`. DATA_LOSS: damaged bytes, or content of another size. FAILED_PRECONDITION: a newer format version.
  absl::Status Unpack(std::string_view bytes, absl::Span<std::uint8_t> content);

 private:
  struct Contexts;
  std::unique_ptr<Contexts> contexts_;
};

// The Zstandard frame in a tile's bytes, as it is.
inline std::string_view FrameOfTile(std::string_view bytes) { return bytes.substr(bytes.empty() ? 0 : 1); }

}  // namespace enfilade::grid
