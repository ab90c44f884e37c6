// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "storage/postgres/driver/types.h"

namespace enfilade::storage::postgres {

// Rows for COPY ... FROM STDIN (FORMAT binary), each column in PostgreSQL's binary format, without copies of what goes
// in. Per row: BeginRow, then every column in the order of the COPY.
class CopyBuffer {
 public:
  CopyBuffer() {
    bytes_.append("PGCOPY\n\377\r\n\0", 11);
    AppendBinary(std::int32_t{0}, bytes_);  // flags
    AppendBinary(std::int32_t{0}, bytes_);  // length of the header's extension
  }

  void Reserve(std::size_t bytes) { bytes_.reserve(bytes_.size() + bytes); }

  void BeginRow(std::int16_t columns) { AppendBinary(columns, bytes_); }
  template <typename T>
  requires std::is_arithmetic_v<T>
  void Put(T value) {
    AppendBinary(static_cast<std::int32_t>(sizeof(T)), bytes_);
    AppendBinary(value, bytes_);
  }
  // Of a text or bytea column.
  void Put(std::string_view value) {
    AppendBinary(static_cast<std::int32_t>(value.size()), bytes_);
    bytes_.append(value);
  }
  // A text or bytea column whose bytes `append(std::string&)` adds to the buffer; returns how many it were.
  template <typename Append>
  std::size_t PutAppended(const Append& append) {
    const std::size_t place = bytes_.size();
    bytes_.append(sizeof(std::int32_t), '\0');
    append(bytes_);
    const std::size_t size = bytes_.size() - place - sizeof(std::int32_t);
    const std::uint32_t network = ToNetwork(static_cast<std::uint32_t>(size));
    bytes_.replace(place, sizeof(network), reinterpret_cast<const char*>(&network), sizeof(network));
    return size;
  }

  // The whole, with the end mark. Nothing may be added any more.
  std::string_view Finish() {
    AppendBinary(std::int16_t{-1}, bytes_);
    return bytes_;
  }

 private:
  std::string bytes_;
};

}  // namespace enfilade::storage::postgres
