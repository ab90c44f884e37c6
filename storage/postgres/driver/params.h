// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/types/span.h"
#include "core/base/ids.h"
#include "core/base/time.h"
#include "storage/postgres/driver/types.h"

namespace enfilade::storage::postgres {

// Marks bytes to be bound as bytea, where a plain std::string_view is bound as text.
struct Bytes {
  std::string_view value;
};
// Marks a time to be bound as timestamptz, in whole microseconds.
struct Timestamp {
  TimeNs value;
};

// The values of a statement's parameters $1, $2, ..., in PostgreSQL's binary format. Texts and bytes are referred to,
// not copied: they must live until the statement has been queued.
class Params {
 public:
  template <typename... Ts>
  explicit Params(const Ts&... values) {
    params_.reserve(sizeof...(values));
    (Add(values), ...);
  }

  void Add(bool value) { AddFixed(TypeOid::kBool, value); }
  void Add(std::int16_t value) { AddFixed(TypeOid::kInt2, value); }
  void Add(std::int32_t value) { AddFixed(TypeOid::kInt4, value); }
  void Add(std::int64_t value) { AddFixed(TypeOid::kInt8, value); }
  void Add(double value) { AddFixed(TypeOid::kFloat8, value); }
  void Add(Timestamp value) { AddFixed(TypeOid::kTimestamptz, TimestampFromTime(value.value)); }
  void Add(std::string_view value) { params_.push_back({TypeOid::kText, value.data(), value.size(), kView}); }
  void Add(const std::string& value) { Add(std::string_view(value)); }
  void Add(const char* value) { Add(std::string_view(value)); }
  void Add(Bytes value) { params_.push_back({TypeOid::kBytea, value.value.data(), value.value.size(), kView}); }
  template <typename Tag>
  void Add(const Id<Tag>& id) {
    Add(std::string_view(id.value()));
  }
  template <typename T>
  void Add(const std::optional<T>& value) {
    if (value) return Add(*value);
    Add(T{});
    params_.back().place = kNull;
  }
  void Add(const std::vector<std::int16_t>& values) { AddArray(TypeOid::kInt2Array, TypeOid::kInt2, values); }
  void Add(const std::vector<std::int32_t>& values) { AddArray(TypeOid::kInt4Array, TypeOid::kInt4, values); }
  void Add(const std::vector<std::int64_t>& values) { AddArray(TypeOid::kInt8Array, TypeOid::kInt8, values); }
  void Add(const std::vector<double>& values) { AddArray(TypeOid::kFloat8Array, TypeOid::kFloat8, values); }
  void Add(const std::vector<std::string_view>& values) { AddArray(TypeOid::kTextArray, TypeOid::kText, values); }
  void Add(const std::vector<Bytes>& values) { AddArray(TypeOid::kByteaArray, TypeOid::kBytea, values); }

  int size() const { return static_cast<int>(params_.size()); }

  // As libpq takes them; the pointers hold while this lives unchanged.
  struct Bound {
    std::vector<unsigned> types;
    std::vector<const char*> values;
    std::vector<int> lengths;
    std::vector<int> formats;
  };
  Bound Bind() const;

 private:
  static constexpr std::size_t kView = static_cast<std::size_t>(-1);
  static constexpr std::size_t kNull = static_cast<std::size_t>(-2);
  struct Param {
    TypeOid type;
    const char* view;
    std::size_t size;
    std::size_t place;  // the offset in buffer_, or kView, or kNull
  };

  template <typename T>
  void AddFixed(TypeOid type, T value) {
    const std::size_t place = buffer_.size();
    AppendBinary(value, buffer_);
    params_.push_back({type, nullptr, buffer_.size() - place, place});
  }

  template <typename T>
  void AddArray(TypeOid type, TypeOid element_type, const std::vector<T>& values) {
    const std::size_t place = buffer_.size();
    AppendArrayHeader(element_type, values.size());
    for (const T& value : values) AppendElement(value);
    params_.push_back({type, nullptr, buffer_.size() - place, place});
  }
  void AppendArrayHeader(TypeOid element_type, std::size_t count);
  void AppendElement(std::string_view value);
  void AppendElement(Bytes value) { AppendElement(value.value); }
  template <typename T>
  requires std::is_arithmetic_v<T>
  void AppendElement(T value) {
    AppendBinary(static_cast<std::int32_t>(sizeof(T)), buffer_);
    AppendBinary(value, buffer_);
  }

  std::string buffer_;
  std::vector<Param> params_;
};

}  // namespace enfilade::storage::postgres
