// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace enfilade::grid {

// Reads a JSON text (RFC 8259) token by token: for files that are one long array of numbers, where a document in memory
// would take many times the size of the text (docs/adr/0007 compares libraries). Numbers are converted exactly. All
// errors are INVALID_ARGUMENT with the line.
class JsonScanner {
 public:
  explicit JsonScanner(std::string_view text) : text_(text) {}

  // Consumes the structural character `c`, after white space.
  absl::Status Expect(char c);
  // The same, but returns false and consumes nothing if the next character is another.
  bool Accept(char c);
  // Checks that only white space follows.
  absl::Status ExpectEnd();

  // A string without its quotes. Escapes are not decoded: callers compare with plain words.
  absl::StatusOr<std::string_view> String();
  // JSON has no NaN or infinity; a number beyond the range of a double is an error.
  absl::StatusOr<double> Number();
  // Skips one value of any kind.
  absl::Status SkipValue();

  std::size_t remaining() const { return text_.size() - position_; }
  // "message (line 7)".
  absl::Status ErrorHere(std::string_view message) const;

 private:
  void SkipSpace();
  absl::Status SkipValue(int depth);
  absl::Status SkipMembers(char close, int depth);

  std::string_view text_;
  std::size_t position_ = 0;
};

}  // namespace enfilade::grid
