// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace enfilade {

static_assert(std::endian::native == std::endian::little, "the binary formats are little-endian");

// Appends fixed-size little-endian values to a string.
class BinaryWriter {
 public:
  explicit BinaryWriter(std::string& out) : out_(out) {}

  template <typename T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T>
  void Put(T value) { out_.append(reinterpret_cast<const char*>(&value), sizeof(T)); }
  void PutBytes(std::string_view bytes) { out_.append(bytes); }
  // A 64-bit length, then the bytes.
  void PutString(std::string_view bytes) {
    Put<std::uint64_t>(bytes.size());
    PutBytes(bytes);
  }
  template <typename T>
  requires std::is_arithmetic_v<T>
  void PutVector(const std::vector<T>& values) {
    Put<std::uint64_t>(values.size());
    out_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }

 private:
  std::string& out_;
};

// Reads what BinaryWriter wrote. A read past the end returns zeros and makes `ok()` false for good, so a decoder can
// read everything and check once.
class BinaryReader {
 public:
  explicit BinaryReader(std::string_view bytes) : bytes_(bytes) {}

  bool ok() const { return ok_; }
  bool at_end() const { return ok_ && position_ == bytes_.size(); }
  std::size_t remaining() const { return bytes_.size() - position_; }

  template <typename T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T> T Get() {
    if constexpr (std::is_same_v<T, bool>) return Get<std::uint8_t>() != 0;  // any other byte is not a valid bool
    T value{};
    const std::string_view bytes = GetBytes(sizeof(T));
    if (bytes.size() == sizeof(T)) std::memcpy(&value, bytes.data(), sizeof(T));
    return value;
  }
  std::string_view GetBytes(std::size_t size) {
    if (!ok_ || size > remaining()) {
      ok_ = false;
      return {};
    }
    const std::string_view result = bytes_.substr(position_, size);
    position_ += size;
    return result;
  }
  std::string_view GetString() { return GetBytes(GetLength(1)); }
  template <typename T>
  requires std::is_arithmetic_v<T> std::vector<T> GetVector() {
    const std::size_t size = GetLength(sizeof(T));
    const std::string_view bytes = GetBytes(size * sizeof(T));
    std::vector<T> values(ok_ ? size : 0);
    if (!values.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
    return values;
  }

 private:
  // A stored count of elements of `element_size` bytes. Fails before anything is allocated if fewer bytes are left.
  std::size_t GetLength(std::size_t element_size) {
    const auto length = Get<std::uint64_t>();
    if (!ok_ || length > remaining() / element_size) {
      ok_ = false;
      return 0;
    }
    return length;
  }

  std::string_view bytes_;
  std::size_t position_ = 0;
  bool ok_ = true;
};

}  // namespace enfilade
