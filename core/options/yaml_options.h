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

// Options structs as YAML and back, for structs with a function that visits every option by its name: "name", or
// "group.name" for those in a nested map. Include it in source files only.
namespace enfilade::yaml_options {

// "group.name" -> its scalar.
using Values = std::map<std::string, YAML::Node>;

// `what` begins the messages, such as "slam options". INVALID_ARGUMENT naming the line: no YAML, no map, a list, an
// option that comes twice. An empty text has no values.
absl::StatusOr<Values> Load(std::string_view yaml, std::string_view what);

template <typename T>
constexpr const char* kTypeName = "a number";
template <>
inline constexpr const char* kTypeName<bool> = "true or false";
template <>
inline constexpr const char* kTypeName<int> = "a whole number";

// Writes the values into the options: `visit(visitor)` calls visitor(name, value&) for each of them. `also_known`:
// names that the caller reads itself. INVALID_ARGUMENT naming the line: an unknown name, a value of another type.
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
    if (!YAML::convert<Value>::decode(found->second, value)) {
      status = InvalidArgument("{}, line {}: {} is \"{}\", expected {}", what, found->second.Mark().line + 1, name,
                               found->second.Scalar(), kTypeName<Value>);
    }
  });
  if (!status.ok()) return status;
  for (const auto& [name, node] : values) {
    if (known.contains(name)) continue;
    return InvalidArgument("{}, line {}: there is no option {}", what, node.Mark().line + 1, name);
  }
  return absl::OkStatus();
}

// What Load reads, groups in the order in which they are visited.
template <typename Visit>
std::string Format(const Visit& visit) {
  std::string text;
  std::string group;
  visit([&](const std::string& name, const auto& value) {
    const std::size_t dot = name.find('.');
    const std::string of = dot == std::string::npos ? "" : name.substr(0, dot);
    if (of != group) text += fmt::format("{}:\n", of);
    group = of;
    text += dot == std::string::npos ? fmt::format("{}: {}\n", name, value)
                                     : fmt::format("  {}: {}\n", name.substr(dot + 1), value);
  });
  return text;
}

}  // namespace enfilade::yaml_options
