#include "client/cpp/uuid.h"

#include <array>
#include <cstdint>
#include <random>

#include "fmt/format.h"

namespace enfilade::client {

std::string NewUuid() {
  std::random_device random;
  std::array<std::uint32_t, 4> bits{};
  for (std::uint32_t& word : bits) word = random();
  return fmt::format("{:08x}-{:04x}-4{:03x}-{:04x}-{:04x}{:08x}", bits[0], bits[1] >> 16, bits[1] & 0xFFFU,
                     0x8000U | (bits[2] >> 16 & 0x3FFFU), bits[2] & 0xFFFFU, bits[3]);
}

}  // namespace enfilade::client
