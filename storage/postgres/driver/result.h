// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "core/base/time.h"
#include "storage/postgres/driver/types.h"

struct pg_result;

namespace enfilade::storage::postgres {

// The rows that a statement gave, in binary.
class Result {
 public:
  explicit Result(pg_result* result) : result_(result) {}

  int rows() const;
  int columns() const;
  // Rows that an INSERT, UPDATE, DELETE or SELECT touched.
  std::int64_t affected() const;
  const pg_result* get() const { return result_.get(); }

 private:
  struct Clear {
    void operator()(pg_result* result) const;
  };
  std::unique_ptr<pg_result, Clear> result_;
};

// Reads the columns of one row from left to right. A column of another type than asked for, NULL where none is
// expected, or a missing column make the reader fail for good: check `status()` once after the last column. Views live
// as long as the result.
class Row {
 public:
  Row(const Result& result, int row, int first_column = 0) : result_(result), row_(row), column_(first_column) {}

  bool Bool() { return Fixed<bool>(TypeOid::kBool); }
  std::int16_t Int16() { return Fixed<std::int16_t>(TypeOid::kInt2); }
  std::int32_t Int32() { return Fixed<std::int32_t>(TypeOid::kInt4); }
  std::int64_t Int64() { return Fixed<std::int64_t>(TypeOid::kInt8); }
  double Double() { return Fixed<double>(TypeOid::kFloat8); }
  TimeNs Time() { return TimeFromTimestamp(Fixed<std::int64_t>(TypeOid::kTimestamptz)); }
  std::string_view Text() { return Value(TypeOid::kText).value_or(""); }
  std::string_view Bytes() { return Value(TypeOid::kBytea).value_or(""); }
  // A one-dimensional float8[] without nulls.
  std::vector<double> Doubles();
  // The same into `numbers`. False, and nothing is written, if the count differs.
  bool DoublesInto(absl::Span<double> numbers);
  // A one-dimensional text[] without nulls; none for NULL.
  std::vector<std::string> OptionalTexts();
  std::optional<double> OptionalDouble();

  std::optional<std::string_view> OptionalText() { return NullableValue(TypeOid::kText); }
  std::optional<std::string_view> OptionalBytes() { return NullableValue(TypeOid::kBytea); }
  std::optional<std::int64_t> OptionalInt64();
  std::optional<TimeNs> OptionalTime();

  // INTERNAL naming the column: the statement and the code that reads it do not fit together.
  const absl::Status& status() const { return status_; }

 private:
  template <typename T>
  T Fixed(TypeOid type) {
    const auto value = Value(type);
    return value && HasSize(*value, sizeof(T)) ? DecodeBinary<T>(value->data()) : T{};
  }

  // The elements of a float8[], each after its length.
  std::string_view DoubleElements();
  bool HasSize(std::string_view value, std::size_t size);
  std::optional<std::string_view> Value(TypeOid type);
  std::optional<std::string_view> NullableValue(TypeOid type);
  void Fail(std::string_view why);

  const Result& result_;
  int row_;
  int column_;
  absl::Status status_;
};

}  // namespace enfilade::storage::postgres
