// SPDX-License-Identifier: Apache-2.0
#include "core/grid/files/json_scanner.h"

#include <algorithm>
#include <charconv>

#include "absl/strings/ascii.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::grid {
namespace {

constexpr int kMaxDepth = 64;

// Excludes what std::from_chars accepts beyond JSON: a point or sign without digits, leading zeros, words.
bool IsJsonNumber(std::string_view token) {
  const std::string_view digits = token.substr(token.starts_with('-') ? 1 : 0);
  if (digits.empty() || !absl::ascii_isdigit(digits.front()) || !absl::ascii_isdigit(digits.back())) return false;
  if (digits.size() > 1 && digits[0] == '0' && absl::ascii_isdigit(digits[1])) return false;
  const std::size_t point = digits.find('.');
  return point == std::string_view::npos || absl::ascii_isdigit(digits[point + 1]);
}

}  // namespace

absl::Status JsonScanner::ErrorHere(std::string_view message) const {
  const std::string_view before = text_.substr(0, position_);
  return InvalidArgument("{} (line {})", message, std::count(before.begin(), before.end(), '\n') + 1);
}

void JsonScanner::SkipSpace() {
  while (position_ < text_.size()) {
    const char c = text_[position_];
    if (c != ' ' && c != '\n' && c != '\t' && c != '\r') return;
    ++position_;
  }
}

bool JsonScanner::Accept(char c) {
  SkipSpace();
  if (position_ == text_.size() || text_[position_] != c) return false;
  ++position_;
  return true;
}

absl::Status JsonScanner::Expect(char c) {
  if (Accept(c)) return absl::OkStatus();
  if (position_ == text_.size()) return ErrorHere(fmt::format("the JSON text ends where '{}' is expected", c));
  return ErrorHere(fmt::format("the JSON text has '{}' where '{}' is expected", text_[position_], c));
}

absl::Status JsonScanner::ExpectEnd() {
  SkipSpace();
  return position_ == text_.size() ? absl::OkStatus() : ErrorHere("the JSON text has content after its object");
}

absl::StatusOr<std::string_view> JsonScanner::String() {
  ENFILADE_RETURN_IF_ERROR(Expect('"'));
  const std::size_t begin = position_;
  while (position_ < text_.size() && text_[position_] != '"') position_ += text_[position_] == '\\' ? 2 : 1;
  if (position_ >= text_.size()) {
    position_ = text_.size();
    return ErrorHere("the JSON text ends within a string");
  }
  return text_.substr(begin, position_++ - begin);
}

absl::StatusOr<double> JsonScanner::Number() {
  SkipSpace();
  const char* const begin = text_.data() + position_;
  double value = 0.0;
  const std::from_chars_result result = std::from_chars(begin, text_.data() + text_.size(), value);
  const std::string_view token(begin, static_cast<std::size_t>(result.ptr - begin));
  if (!IsJsonNumber(token)) return ErrorHere("the JSON text has no number where one is expected");
  if (result.ec != std::errc()) return ErrorHere(fmt::format("the number {} is beyond a double's range", token));
  position_ += token.size();
  return value;
}

absl::Status JsonScanner::SkipValue() { return SkipValue(0); }

absl::Status JsonScanner::SkipValue(int depth) {
  if (depth > kMaxDepth) return ErrorHere("the JSON text is nested too deeply");
  if (Accept('{')) return SkipMembers('}', depth);
  if (Accept('[')) return SkipMembers(']', depth);
  if (position_ < text_.size() && text_[position_] == '"') return String().status();
  for (const std::string_view word : {"true", "false", "null"}) {
    if (text_.substr(position_).starts_with(word)) {
      position_ += word.size();
      return absl::OkStatus();
    }
  }
  return Number().status();
}

// The rest of an object or array after its opening character.
absl::Status JsonScanner::SkipMembers(char close, int depth) {
  if (Accept(close)) return absl::OkStatus();
  do {
    if (close == '}') {
      ENFILADE_RETURN_IF_ERROR(String().status());
      ENFILADE_RETURN_IF_ERROR(Expect(':'));
    }
    ENFILADE_RETURN_IF_ERROR(SkipValue(depth + 1));
  } while (Accept(','));
  return Expect(close);
}

}  // namespace enfilade::grid
