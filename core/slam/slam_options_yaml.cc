#include "core/slam/slam_options_yaml.h"

#include <yaml-cpp/yaml.h>

#include <map>
#include <set>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/slam/slam_option_names.h"

namespace enfilade {
namespace {

// "group.name" -> its scalar.
absl::Status Flatten(const YAML::Node& node, const std::string& prefix, std::map<std::string, YAML::Node>& values) {
  if (!node.IsMap()) return InvalidArgument("slam options, line {}: expected a map of options", node.Mark().line + 1);
  for (const auto& entry : node) {
    const std::string name = prefix + entry.first.Scalar();
    if (entry.second.IsMap() && prefix.empty()) {
      ENFILADE_RETURN_IF_ERROR(Flatten(entry.second, name + ".", values));
    } else if (!entry.second.IsScalar()) {
      return InvalidArgument("slam options, line {}: {} is not a single value", entry.first.Mark().line + 1, name);
    } else if (!values.emplace(name, entry.second).second) {
      return InvalidArgument("slam options, line {}: {} comes twice", entry.first.Mark().line + 1, name);
    }
  }
  return absl::OkStatus();
}

template <typename T>
constexpr const char* kTypeName = "a number";
template <>
constexpr const char* kTypeName<bool> = "true or false";
template <>
constexpr const char* kTypeName<int> = "a whole number";

absl::Status Assign(const std::map<std::string, YAML::Node>& values, SlamOptions& options) {
  absl::Status status;
  std::set<std::string> known;
  VisitSlamOptions(options, [&](const char* name, auto& value) {
    known.insert(name);
    const auto found = values.find(name);
    if (found == values.end() || !status.ok()) return;
    if (!YAML::convert<std::decay_t<decltype(value)>>::decode(found->second, value)) {
      status = InvalidArgument("slam options, line {}: {} is \"{}\", expected {}", found->second.Mark().line + 1, name,
                               found->second.Scalar(), kTypeName<std::decay_t<decltype(value)>>);
    }
  });
  ENFILADE_RETURN_IF_ERROR(status);
  for (const auto& [name, node] : values) {
    if (!known.contains(name)) {
      return InvalidArgument("slam options, line {}: there is no option {}", node.Mark().line + 1, name);
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<SlamOptions> ParseSlamOptions(std::string_view yaml) {
  SlamOptions options;
  try {
    const YAML::Node root = YAML::Load(std::string(yaml));
    if (!root.IsNull()) {
      std::map<std::string, YAML::Node> values;
      ENFILADE_RETURN_IF_ERROR(Flatten(root, "", values));
      ENFILADE_RETURN_IF_ERROR(Assign(values, options));
    }
  } catch (const YAML::Exception& error) {
    return InvalidArgument("slam options: {}", error.what());
  }
  ENFILADE_RETURN_IF_ERROR(options.Validate());
  return options;
}

std::string FormatSlamOptions(const SlamOptions& options) {
  std::string text;
  std::string group;
  VisitSlamOptions(options, [&](const std::string& name, const auto& value) {
    const std::size_t dot = name.find('.');
    const std::string of = dot == std::string::npos ? "" : name.substr(0, dot);
    if (of != group) text += fmt::format("{}:\n", of);
    group = of;
    text += dot == std::string::npos ? fmt::format("{}: {}\n", name, value)
                                     : fmt::format("  {}: {}\n", name.substr(dot + 1), value);
  });
  return text;
}

}  // namespace enfilade
