// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>

#include "core/base/time.h"

namespace enfilade::storage::postgres {

// PostgreSQL's type numbers (pg_type.dat); fixed for built-in types.
enum class TypeOid : unsigned {
  kBool = 16,
  kBytea = 17,
  kInt8 = 20,
  kInt2 = 21,
  kInt4 = 23,
  kText = 25,
  kFloat8 = 701,
  kByteaArray = 1001,
  kInt2Array = 1005,
  kInt4Array = 1007,
  kTextArray = 1009,
  kInt8Array = 1016,
  kFloat8Array = 1022,
  kTimestamptz = 1184,
};

// PostgreSQL's binary formats are big-endian.
inline std::uint16_t ToNetwork(std::uint16_t value) { return __builtin_bswap16(value); }
inline std::uint32_t ToNetwork(std::uint32_t value) { return __builtin_bswap32(value); }
inline std::uint64_t ToNetwork(std::uint64_t value) { return __builtin_bswap64(value); }
static_assert(std::endian::native == std::endian::little);

template <typename Unsigned>
void AppendNetwork(Unsigned value, std::string& out) {
  const Unsigned network = ToNetwork(value);
  out.append(reinterpret_cast<const char*>(&network), sizeof(network));
}
inline void AppendBinary(bool value, std::string& out) { out.push_back(value ? 1 : 0); }
inline void AppendBinary(std::int16_t value, std::string& out) { AppendNetwork<std::uint16_t>(value, out); }
inline void AppendBinary(std::int32_t value, std::string& out) { AppendNetwork<std::uint32_t>(value, out); }
inline void AppendBinary(std::int64_t value, std::string& out) { AppendNetwork<std::uint64_t>(value, out); }
inline void AppendBinary(double value, std::string& out) { AppendNetwork(std::bit_cast<std::uint64_t>(value), out); }

template <typename Unsigned>
Unsigned ReadNetwork(const char* bytes) {
  Unsigned network;
  std::memcpy(&network, bytes, sizeof(network));
  return ToNetwork(network);
}

template <typename T>
T DecodeBinary(const char* bytes) {
  if constexpr (std::is_same_v<T, bool>) {
    return *bytes != 0;
  } else if constexpr (std::is_same_v<T, double>) {
    return std::bit_cast<double>(ReadNetwork<std::uint64_t>(bytes));
  } else {
    return static_cast<T>(ReadNetwork<std::make_unsigned_t<T>>(bytes));
  }
}

// timestamptz counts microseconds from 2000-01-01 UTC.
constexpr std::int64_t kEpochOffsetUs = 946'684'800'000'000;
constexpr TimeNs TimeFromTimestamp(std::int64_t timestamp_us) { return (timestamp_us + kEpochOffsetUs) * 1000; }
constexpr std::int64_t TimestampFromTime(TimeNs time) { return time / 1000 - kEpochOffsetUs; }

}  // namespace enfilade::storage::postgres
