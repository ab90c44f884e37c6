// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace enfilade::grid {

// Reads a JSON text (RFC 8259) token by token: for files that are one long array of numbers, for which a document in
// memory would be many times the text. Numbers are converted exactly. All errors are INVALID_ARGUMENT with the line.
class JsonScanner {
 public:
  explicit JsonScanner(std::string_view text) : text_(text) {}

  // The character `c` (one of the structural ones), past white space.
  absl::Status Expect(char c);
  // The same, but false and no step where something else comes.
  bool Accept(char c);
  // Nothing but white space may follow.
  absl::Status ExpectEnd();

  // A string without its quotes; escapes are kept as they are written, which serves to compare with plain words.
  absl::StatusOr<std::string_view> String();
  // JSON has neither NaN nor infinities; a number beyond a double's range is an error.
  absl::StatusOr<double> Number();
  // Steps over one value of any kind.
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
