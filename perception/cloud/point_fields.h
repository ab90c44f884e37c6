// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "perception/cloud/cloud.h"

namespace enfilade::perception {

// A field of a point, as described by the header of a cloud file.
struct PointField {
  enum class Kind { kFloat, kSigned, kUnsigned };

  std::string name;
  Kind kind = Kind::kFloat;
  std::size_t size = 4;   // bytes
  std::size_t count = 1;  // PCD: numbers under this name
};

// The indices of the fields x, y and z. INVALID_ARGUMENT: one is missing or not a single float.
absl::StatusOr<std::array<std::size_t, 3>> FindXyz(const std::vector<PointField>& fields);

// Reads points of fixed size, stored one after another. `bytes` must hold at least `count` of them.
Cloud ReadRows(std::string_view bytes, std::size_t count, const std::vector<PointField>& fields,
               const std::array<std::size_t, 3>& xyz);
// Reads points stored by field: all values of the first, then all of the second.
Cloud ReadColumns(std::string_view bytes, std::size_t count, const std::vector<PointField>& fields,
                  const std::array<std::size_t, 3>& xyz);
// Reads lines of numbers; "nan" and "inf" are numbers. INVALID_ARGUMENT names the point that cannot be read.
absl::StatusOr<Cloud> ReadText(std::string_view text, std::size_t count, const std::vector<PointField>& fields,
                               const std::array<std::size_t, 3>& xyz);

std::size_t PointSize(const std::vector<PointField>& fields);

// Removes the next line from `text` and returns it without its line end; nullopt if there is none.
std::optional<std::string_view> TakeLine(std::string_view& text);
// The words of a line, separated by spaces and tabs.
std::vector<std::string_view> Words(std::string_view line);
std::optional<std::size_t> ParseCount(std::string_view word);

}  // namespace enfilade::perception
