// SPDX-License-Identifier: Apache-2.0
#include "core/options/yaml_options.h"

#include "core/base/status_macros.h"

namespace enfilade::yaml_options {
namespace {

absl::Status Flatten(const YAML::Node& node, const std::string& prefix, std::string_view what, Values& values) {
  if (!node.IsMap()) return InvalidArgument("{}, line {}: expected a map of options", what, node.Mark().line + 1);
  for (const auto& entry : node) {
    const std::string name = prefix + entry.first.Scalar();
    if (entry.second.IsMap() && prefix.empty()) {
      ENFILADE_RETURN_IF_ERROR(Flatten(entry.second, name + ".", what, values));
    } else if (!entry.second.IsScalar()) {
      return InvalidArgument("{}, line {}: {} is not a single value", what, entry.first.Mark().line + 1, name);
    } else if (!values.emplace(name, entry.second).second) {
      return InvalidArgument("{}, line {}: {} comes twice", what, entry.first.Mark().line + 1, name);
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Values> Load(std::string_view yaml, std::string_view what) {
  Values values;
  try {
    const YAML::Node root = YAML::Load(std::string(yaml));
    if (!root.IsNull()) ENFILADE_RETURN_IF_ERROR(Flatten(root, "", what, values));
  } catch (const YAML::Exception& error) {
    return InvalidArgument("{}: {}", what, error.what());
  }
  return values;
}

}  // namespace enfilade::yaml_options
