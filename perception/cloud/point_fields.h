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

// One number of a point, as the header of a cloud file describes it.
struct PointField {
  enum class Kind { kFloat, kSigned, kUnsigned };

  std::string name;
  Kind kind = Kind::kFloat;
  std::size_t size = 4;   // bytes
  std::size_t count = 1;  // PCD: numbers under this name
};

// Which of the fields are x, y and z. INVALID_ARGUMENT where one is missing or no float.
absl::StatusOr<std::array<std::size_t, 3>> FindXyz(const std::vector<PointField>& fields);

// Points of fixed size, one after the other. `bytes` holds at least `count` of them.
Cloud ReadRows(std::string_view bytes, std::size_t count, const std::vector<PointField>& fields,
               const std::array<std::size_t, 3>& xyz);
// All values of the first field, then all of the second.
Cloud ReadColumns(std::string_view bytes, std::size_t count, const std::vector<PointField>& fields,
                  const std::array<std::size_t, 3>& xyz);
// Lines of numbers; "nan" and "inf" are numbers. INVALID_ARGUMENT naming the point that cannot be read.
absl::StatusOr<Cloud> ReadText(std::string_view text, std::size_t count, const std::vector<PointField>& fields,
                               const std::array<std::size_t, 3>& xyz);

std::size_t PointSize(const std::vector<PointField>& fields);

// Takes the next line, without its end, off `text`; nullopt where none is left.
std::optional<std::string_view> TakeLine(std::string_view& text);
// The words of a line, apart from spaces and tabs.
std::vector<std::string_view> Words(std::string_view line);
std::optional<std::size_t> ParseCount(std::string_view word);

}  // namespace enfilade::perception
