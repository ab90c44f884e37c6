// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <yaml-cpp/yaml.h>

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/error.h"
#include "core/options/yaml_document.h"

// Options structs as YAML and back, for structs with a function that visits every option by its name: "name", or
// "group.name" for those in a nested mapping. Include it in source files only.
namespace enfilade::yaml_options {

// "group.name" -> its scalar.
using Values = std::map<std::string, YAML::Node>;

// `what` begins the messages, such as "slam options". INVALID_ARGUMENT with the line: not valid YAML, not a mapping, a
// list, an option that is set twice. An empty text has no values.
absl::StatusOr<Values> Load(std::string_view yaml, std::string_view what);

// Writes the values into the options: `visit(visitor)` calls visitor(name, value&) for each option. `also_known`: names
// that the caller reads itself. INVALID_ARGUMENT with the line: an unknown name, a value of the wrong type.
template <typename Visit>
absl::Status Assign(const Values& values, std::string_view what, const Visit& visit,
                    std::set<std::string> also_known = {}) {
  absl::Status status;
  std::set<std::string>& known = also_known;
  visit([&](const char* name, auto& value) {
    known.insert(name);
    const auto found = values.find(name);
    if (found == values.end() || !status.ok()) return;
    using Value = std::decay_t<decltype(value)>;
    if (auto scalar = ScalarAs<Value>(found->second)) {
      value = *std::move(scalar);
    } else {
      status = InvalidArgument("{}: {} is \"{}\", expected {}", Location(what, found->second.Mark()), name,
                               found->second.Scalar(), TypeName<Value>());
    }
  });
  if (!status.ok()) return status;
  for (const auto& [name, node] : values) {
    if (known.contains(name)) continue;
    return InvalidArgument("{}: there is no option {}", Location(what, node.Mark()), name);
  }
  return absl::OkStatus();
}

// The text that Load reads, with groups in the order in which they are visited.
template <typename Visit>
std::string Format(const Visit& visit) {
  std::string text;
  std::string group;
  visit([&](const std::string& name, const auto& value) {
    const std::size_t dot = name.find('.');
    const std::string group_of_name = dot == std::string::npos ? "" : name.substr(0, dot);
    if (group_of_name != group) text += fmt::format("{}:\n", group_of_name);
    group = group_of_name;
    text += dot == std::string::npos ? fmt::format("{}: {}\n", name, value)
                                     : fmt::format("  {}: {}\n", name.substr(dot + 1), value);
  });
  return text;
}

}  // namespace enfilade::yaml_options
