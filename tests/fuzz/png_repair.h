// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <zlib.h>

#include <cstdint>
#include <string>
#include <string_view>

namespace enfilade::fuzz {

inline std::uint32_t BigEndian(const char* bytes) {
  std::uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint8_t>(bytes[i]);
  return value;
}

// The PNG with the right checksum for each of its chunks, whose bytes may have been changed: otherwise no change would
// get past libpng's check.
inline std::string WithValidChecksums(std::string_view png) {
  std::string repaired(png);
  for (std::size_t at = 8; at + 12 <= repaired.size();) {
    const std::size_t size = BigEndian(&repaired[at]);
    if (size > repaired.size() - at - 12) break;
    const auto* checked = reinterpret_cast<const Bytef*>(&repaired[at + 4]);
    const auto sum = static_cast<std::uint32_t>(crc32(0, checked, static_cast<uInt>(size + 4)));
    for (std::size_t i = 0; i < 4; ++i) repaired[at + 8 + size + i] = static_cast<char>(sum >> (24 - 8 * i));
    at += size + 12;
  }
  return repaired;
}

}  // namespace enfilade::fuzz
