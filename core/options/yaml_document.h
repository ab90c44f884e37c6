// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <yaml-cpp/yaml.h>

#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "absl/status/status.h"

// What the readers of YAML have in common: parsing, typed scalars, and messages that name the line. Include it in
// source files only.
namespace enfilade::yaml_options {

// "slam options, line 3"; "line 3" if `what` is empty; "slam options" if the line is unknown. `mark` counts from 0.
std::string Location(std::string_view what, const YAML::Mark& mark);

// INVALID_ARGUMENT with the location of an exception of yaml-cpp.
absl::Status ToStatus(const YAML::Exception& error, std::string_view what);

// Parses the text and gives what `read` makes of its root (null for an empty text): a status or a StatusOr.
// INVALID_ARGUMENT with the location: the text is not valid YAML, or `read` uses a node as what it is not.
template <typename Read>
auto ReadYaml(std::string_view text, std::string_view what, const Read& read)
    -> decltype(read(std::declval<const YAML::Node&>())) {
  try {
    const YAML::Node root = YAML::Load(std::string(text));
    return read(root);
  } catch (const YAML::Exception& error) {
    return ToStatus(error, what);
  }
}

// "a number", "a whole number", "true or false", "text": for messages.
template <typename T>
constexpr const char* TypeName() {
  if constexpr (std::is_same_v<T, bool>) return "true or false";
  if constexpr (std::is_integral_v<T>) return "a whole number";
  if constexpr (std::is_floating_point_v<T>) return "a number";
  return "text";
}

// The scalar as a T; nullopt if the node is not a scalar or its text is not a T.
template <typename T>
std::optional<T> ScalarAs(const YAML::Node& node) {
  T value;
  if (!node.IsDefined() || !node.IsScalar() || !YAML::convert<T>::decode(node, value)) return std::nullopt;
  return value;
}

}  // namespace enfilade::yaml_options
