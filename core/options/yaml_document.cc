// SPDX-License-Identifier: Apache-2.0
#include "core/options/yaml_document.h"

#include "core/base/error.h"

namespace enfilade::yaml_options {

std::string Location(std::string_view what, const YAML::Mark& mark) {
  if (mark.is_null() && !what.empty()) return std::string(what);
  return what.empty() ? fmt::format("line {}", mark.line + 1) : fmt::format("{}, line {}", what, mark.line + 1);
}

absl::Status ToStatus(const YAML::Exception& error, std::string_view what) {
  return InvalidArgument("{}: {}", Location(what, error.mark), error.msg);
}

}  // namespace enfilade::yaml_options
