// SPDX-License-Identifier: Apache-2.0
#include "core/options/yaml_options.h"

#include "core/base/status_macros.h"

namespace enfilade::yaml_options {
namespace {

absl::Status Flatten(const YAML::Node& node, const std::string& prefix, std::string_view what, Values& values) {
  if (!node.IsMap()) return InvalidArgument("{}: expected a mapping of options", Location(what, node.Mark()));
  for (const auto& entry : node) {
    const std::string name = prefix + entry.first.Scalar();
    if (entry.second.IsMap()) {
      ENFILADE_RETURN_IF_ERROR(Flatten(entry.second, name + ".", what, values));
    } else if (!entry.second.IsScalar()) {
      return InvalidArgument("{}: {} is not a single value", Location(what, entry.first.Mark()), name);
    } else if (!values.emplace(name, entry.second).second) {
      return InvalidArgument("{}: {} is set twice", Location(what, entry.first.Mark()), name);
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Values> Load(std::string_view yaml, std::string_view what) {
  return ReadYaml(yaml, what, [&](const YAML::Node& root) -> absl::StatusOr<Values> {
    Values values;
    if (!root.IsNull()) ENFILADE_RETURN_IF_ERROR(Flatten(root, "", what, values));
    return values;
  });
}

}  // namespace enfilade::yaml_options
