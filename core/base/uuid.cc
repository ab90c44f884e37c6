// SPDX-License-Identifier: Apache-2.0
#include "core/base/uuid.h"

#include <openssl/rand.h>

#include <array>
#include <new>
#include <string_view>

#include "core/base/sha256.h"

namespace enfilade {

std::string NewUuid() {
  std::array<unsigned char, 16> bytes{};
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1) throw std::bad_alloc();
  bytes[6] = static_cast<unsigned char>((bytes[6] & 0x0F) | 0x40);
  bytes[8] = static_cast<unsigned char>((bytes[8] & 0x3F) | 0x80);
  std::string uuid = ToHex({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  for (const std::size_t position : {20U, 16U, 12U, 8U}) uuid.insert(position, 1, '-');
  return uuid;
}

}  // namespace enfilade
