// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/mutate.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace enfilade::fuzz {
namespace {

constexpr std::array<std::uint64_t, 14> kBinaryExtremes = {0,
                                                           1,
                                                           0x7F,
                                                           0x80,
                                                           0xFF,
                                                           0x7FFF,
                                                           0xFFFF,
                                                           0x7FFFFFFF,
                                                           0x80000000,
                                                           0xFFFFFFFF,
                                                           0x7FF0000000000000,  // infinity
                                                           0x7FF8000000000000,  // NaN
                                                           0x7FFFFFFFFFFFFFFF,
                                                           0xFFFFFFFFFFFFFFFF};
constexpr std::array<std::string_view, 16> kTextExtremes = {
    "-1",         "0", "-0", "1e308", "-1e308", "1e-320", "nan", "inf", "99999999999999999999",
    "2147483648", "[", "{",  "\"",    "\n",     "&a *a",  "\xff"};

std::size_t Below(std::size_t limit, std::mt19937_64& random) { return limit == 0 ? 0 : random() % limit; }

// Of at most `longest` bytes.
std::string_view AnyStretch(std::string_view bytes, std::size_t longest, std::mt19937_64& random) {
  const std::size_t begin = Below(bytes.size(), random);
  return bytes.substr(begin, 1 + Below(longest, random));
}

void OverwriteNumber(std::string& bytes, std::mt19937_64& random) {
  const std::size_t size = std::size_t{1} << Below(4, random);
  if (bytes.size() < size) return;
  const std::uint64_t value = kBinaryExtremes[Below(kBinaryExtremes.size(), random)];
  std::memcpy(bytes.data() + Below(bytes.size() - size + 1, random), &value, size);
}

bool IsPartOfNumber(char c) { return (c >= '0' && c <= '9') || c == '.' || c == '-'; }

// Puts an extreme in the place of the next number in the text.
void ReplaceDecimal(std::string& bytes, std::mt19937_64& random) {
  auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(Below(bytes.size(), random));
  begin = std::find_if(begin, bytes.end(), IsPartOfNumber);
  const auto end = std::find_if_not(begin, bytes.end(), IsPartOfNumber);
  bytes.replace(begin, end, kTextExtremes[Below(kTextExtremes.size(), random)]);
}

void ChangeOnce(const std::vector<std::string>& seeds, std::string& bytes, std::mt19937_64& random) {
  const std::size_t at = Below(bytes.size(), random);
  switch (random() % 8) {
    case 0:
      if (!bytes.empty()) bytes[at] = static_cast<char>(bytes[at] ^ (1 << (random() % 8)));
      break;
    case 1:
      if (!bytes.empty()) bytes[at] = static_cast<char>(random());
      break;
    case 2:
      OverwriteNumber(bytes, random);
      break;
    case 3:
      ReplaceDecimal(bytes, random);
      break;
    case 4:
      bytes.erase(at, 1 + Below(64, random));
      break;
    case 5:
      bytes.insert(at, std::string(AnyStretch(bytes, 256, random)));
      break;
    case 6:
      bytes.insert(at, std::string(AnyStretch(seeds[Below(seeds.size(), random)], 256, random)));
      break;
    default:
      if (random() % 4 == 0) bytes.resize(at);
  }
}

}  // namespace

std::string Mutate(const std::vector<std::string>& seeds, std::mt19937_64& random) {
  std::string bytes = seeds[Below(seeds.size(), random)];
  for (std::size_t changes = 1 + Below(8, random); changes > 0; --changes) ChangeOnce(seeds, bytes, random);
  bytes.resize(std::min(bytes.size(), kMaxInputBytes));
  return bytes;
}

}  // namespace enfilade::fuzz
