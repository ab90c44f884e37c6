// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace enfilade::prior {

// A pair of lines of a DXF file.
struct DxfGroup {
  int code = 0;
  std::string_view value;

  std::optional<double> Number() const;
};

// What begins with group 0, with its groups.
struct DxfEntity {
  std::string_view type;
  std::vector<DxfGroup> groups;

  std::string_view Text(int code) const;                // empty if it is missing
  double Number(int code, double otherwise = 0) const;  // the first with this code
};

struct DxfFile {
  double insert_units = 0;  // $INSUNITS; 0: none
  std::vector<DxfEntity> entities;
  std::map<std::string, std::vector<DxfEntity>, std::less<>> blocks;
};

// Views into `text`. INVALID_ARGUMENT, with the line: not pairs of lines, or no sections.
absl::StatusOr<DxfFile> SplitDxf(std::string_view text);

}  // namespace enfilade::prior
