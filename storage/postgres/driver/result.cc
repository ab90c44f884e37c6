// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/driver/result.h"

#include <libpq-fe.h>

#include <charconv>

#include "core/base/error.h"

namespace enfilade::storage::postgres {
namespace {

// Bytes of an array of one dimension before its elements: dimensions, flags, type, length, lower bound.
constexpr std::size_t kArrayHeader = 20;
constexpr std::size_t kDoubleElement = 12;  // bytes: its length, then the number

void CopyDoubles(std::string_view elements, absl::Span<double> numbers) {
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    numbers[i] = DecodeBinary<double>(elements.data() + i * kDoubleElement + 4);
  }
}

}  // namespace

int Result::rows() const { return PQntuples(result_.get()); }
int Result::columns() const { return PQnfields(result_.get()); }

std::int64_t Result::affected() const {
  const std::string_view text = PQcmdTuples(result_.get());
  std::int64_t count = 0;
  std::from_chars(text.data(), text.data() + text.size(), count);
  return count;
}

void Result::Clear::operator()(pg_result* result) const { PQclear(result); }

std::string_view Row::DoubleElements() {
  const auto value = Value(TypeOid::kFloat8Array);
  if (!value || value->size() < kArrayHeader || ReadNetwork<std::uint32_t>(value->data()) != 1) return {};
  const std::size_t count = ReadNetwork<std::uint32_t>(value->data() + 12);
  if (!HasSize(*value, kArrayHeader + count * kDoubleElement)) return {};
  return value->substr(kArrayHeader);
}

std::vector<double> Row::Doubles() {
  const std::string_view elements = DoubleElements();
  std::vector<double> numbers(elements.size() / kDoubleElement);
  CopyDoubles(elements, absl::MakeSpan(numbers));
  return numbers;
}

bool Row::DoublesInto(absl::Span<double> numbers) {
  const std::string_view elements = DoubleElements();
  if (elements.size() != numbers.size() * kDoubleElement) return false;
  CopyDoubles(elements, numbers);
  return true;
}

std::vector<std::string> Row::OptionalTexts() {
  const auto value = NullableValue(TypeOid::kTextArray);
  std::vector<std::string> texts;
  if (!value || value->size() < kArrayHeader || ReadNetwork<std::uint32_t>(value->data()) != 1) return texts;
  const std::size_t count = ReadNetwork<std::uint32_t>(value->data() + 12);
  std::string_view rest = value->substr(kArrayHeader);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t size = rest.size() < 4 ? rest.size() : ReadNetwork<std::uint32_t>(rest.data());
    if (rest.size() < 4 || size > rest.size() - 4) {
      Fail("ends too early");
      return {};
    }
    texts.emplace_back(rest.substr(4, size));
    rest.remove_prefix(4 + size);
  }
  return texts;
}

std::optional<double> Row::OptionalDouble() {
  const auto value = NullableValue(TypeOid::kFloat8);
  if (!value || !HasSize(*value, 8)) return std::nullopt;
  return DecodeBinary<double>(value->data());
}

std::optional<std::int64_t> Row::OptionalInt64() {
  const auto value = NullableValue(TypeOid::kInt8);
  if (!value || !HasSize(*value, 8)) return std::nullopt;
  return DecodeBinary<std::int64_t>(value->data());
}

std::optional<TimeNs> Row::OptionalTime() {
  const auto value = NullableValue(TypeOid::kTimestamptz);
  if (!value || !HasSize(*value, 8)) return std::nullopt;
  return TimeFromTimestamp(DecodeBinary<std::int64_t>(value->data()));
}

bool Row::HasSize(std::string_view value, std::size_t size) {
  if (value.size() != size) Fail("has an unexpected size");
  return value.size() == size;
}

std::optional<std::string_view> Row::Value(TypeOid type) {
  const auto value = NullableValue(type);
  if (!value) Fail("is NULL");
  return value;
}

std::optional<std::string_view> Row::NullableValue(TypeOid type) {
  const int column = column_++;
  if (!status_.ok()) return std::nullopt;
  if (column >= result_.columns()) {
    Fail("is missing");
  } else if (PQftype(result_.get(), column) != static_cast<unsigned>(type)) {
    Fail("has another type");
  } else if (!PQgetisnull(result_.get(), row_, column)) {
    return std::string_view(PQgetvalue(result_.get(), row_, column),
                            static_cast<std::size_t>(PQgetlength(result_.get(), row_, column)));
  }
  return std::nullopt;
}

void Row::Fail(std::string_view why) {
  if (!status_.ok()) return;
  const char* name = PQfname(result_.get(), column_ - 1);
  status_ = Internal("column {} ({}) of a result {}", column_, name ? name : "?", why);
}

}  // namespace enfilade::storage::postgres
