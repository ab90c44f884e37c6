// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string_view>

namespace enfilade {

// The beginning of a text, for an error message: at most `most` bytes, cut between characters if it is UTF-8.
constexpr std::string_view Excerpt(std::string_view text, std::size_t most) {
  if (text.size() <= most) return text;
  // Bytes 10xxxxxx go on with a character; it has three of them at most.
  std::size_t end = most;
  while (end > 0 && most - end < 3 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  return text.substr(0, end);
}

}  // namespace enfilade
