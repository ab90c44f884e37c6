// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

namespace enfilade::edit {

// `divisor` must be positive.
inline std::int64_t FloorDiv(std::int64_t value, std::int64_t divisor) {
  return value / divisor - (value % divisor < 0 ? 1 : 0);
}
inline std::int64_t CeilDiv(std::int64_t value, std::int64_t divisor) { return -FloorDiv(-value, divisor); }

// floor(sqrt(a b)), which must be less than 2^62.
inline std::int64_t RootOfProduct(std::uint64_t a, std::uint64_t b) {
  __extension__ using Wide = unsigned __int128;
  const Wide product = Wide{a} * b;
  auto root = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(a)) * std::sqrt(static_cast<double>(b)));
  while (Wide{root} * root > product) --root;
  while (Wide{root + 1} * (root + 1) <= product) ++root;
  return static_cast<std::int64_t>(root);
}

// The first of [low, high] from which `holds` is true, which is false before and true at `high`.
template <typename Holds>
int FirstTrue(int low, int high, Holds holds) {
  while (low < high) {
    const int middle = low + (high - low) / 2;
    if (holds(middle)) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  return high;
}
// The last of [low, high] up to which it is true, which it is at `low`.
template <typename Holds>
int LastTrue(int low, int high, Holds holds) {
  while (low < high) {
    const int middle = high - (high - low) / 2;
    if (holds(middle)) {
      low = middle;
    } else {
      high = middle - 1;
    }
  }
  return low;
}

}  // namespace enfilade::edit
