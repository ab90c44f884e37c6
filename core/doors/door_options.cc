#include "core/doors/door_options.h"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <map>
#include <set>
#include <type_traits>

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade {
namespace {

absl::Status Flatten(const YAML::Node& node, const std::string& prefix, std::map<std::string, YAML::Node>& values) {
  if (!node.IsMap()) return InvalidArgument("door options, line {}: expected a map of options", node.Mark().line + 1);
  for (const auto& entry : node) {
    const std::string name = prefix + entry.first.Scalar();
    if (entry.second.IsMap() && prefix.empty()) {
      ENFILADE_RETURN_IF_ERROR(Flatten(entry.second, name + ".", values));
    } else if (!entry.second.IsScalar()) {
      return InvalidArgument("door options, line {}: {} is not a single value", entry.first.Mark().line + 1, name);
    } else if (!values.emplace(name, entry.second).second) {
      return InvalidArgument("door options, line {}: {} comes twice", entry.first.Mark().line + 1, name);
    }
  }
  return absl::OkStatus();
}

absl::Status Assign(const std::map<std::string, YAML::Node>& values, DoorOptions& options) {
  absl::Status status;
  std::set<std::string> known = {"preset"};
  VisitDoorOptions(options, [&](const char* name, auto& value) {
    known.insert(name);
    const auto found = values.find(name);
    if (found == values.end() || !status.ok()) return;
    if (!YAML::convert<std::decay_t<decltype(value)>>::decode(found->second, value)) {
      status = InvalidArgument("door options, line {}: {} is \"{}\": a value of another type",
                               found->second.Mark().line + 1, name, found->second.Scalar());
    }
  });
  ENFILADE_RETURN_IF_ERROR(status);
  for (const auto& [name, node] : values) {
    if (known.contains(name)) continue;
    return InvalidArgument("door options, line {}: there is no option {}", node.Mark().line + 1, name);
  }
  return absl::OkStatus();
}

const char* NameOf(DoorMethod method) { return method == DoorMethod::kGap ? "default" : "original-yaml"; }

}  // namespace

absl::Status DoorOptions::Validate() const {
  absl::Status status;
  VisitDoorOptions(*this, [&](const char* name, const auto& value) {
    const auto number = static_cast<double>(value);
    if (status.ok() && !(number >= 0.0 && number < 1e6))
      status = InvalidArgument("{} is {}: expected 0 or more", name, number);
  });
  ENFILADE_RETURN_IF_ERROR(status);
  if (criteria < 1 || criteria > 3) return InvalidArgument("criteria is {}: expected 1 to 3", criteria);
  if (gap.cell < 0.02 || gap.cell > 0.5) return InvalidArgument("gap.cell is {} m: expected 0.02 to 0.5", gap.cell);
  if (gap.reach > 15.0) return InvalidArgument("gap.reach is {} m: expected up to 15", gap.reach);
  if (gap.max_width <= gap.min_width || gap.max_width > 5.0) {
    return InvalidArgument("gap widths of {} to {} m are none", gap.min_width, gap.max_width);
  }
  if (gap.look_ahead > gap.reach || gap.detour > gap.reach || gap.lag > gap.reach) {
    return InvalidArgument("gap.look_ahead, detour and lag may not be beyond gap.reach, {} m", gap.reach);
  }
  if (derivative.front_sector > 180.0 || derivative.back_sector > 180.0) {
    return InvalidArgument("derivative sectors are up to 180 deg");
  }
  return absl::OkStatus();
}

std::vector<std::string> DoorPresetNames() { return {"default", "original-yaml", "original-code"}; }

absl::StatusOr<DoorOptions> DoorPreset(std::string_view name) {
  DoorOptions options;
  if (name == "default") return options;
  options.method = DoorMethod::kDerivative;
  if (name == "original-yaml") return options;
  if (name != "original-code") {
    return InvalidArgument("there is no preset \"{}\": expected default, original-yaml or original-code", name);
  }
  options.derivative.threshold = 1.0;
  options.environment.filter_half_width = 50;
  return options;
}

absl::StatusOr<DoorOptions> ParseDoorOptions(std::string_view yaml, const DoorOptions& base) {
  DoorOptions options = base;
  try {
    const YAML::Node root = YAML::Load(std::string(yaml));
    if (!root.IsNull()) {
      std::map<std::string, YAML::Node> values;
      ENFILADE_RETURN_IF_ERROR(Flatten(root, "", values));
      if (const auto preset = values.find("preset"); preset != values.end()) {
        ENFILADE_ASSIGN_OR_RETURN(options, DoorPreset(preset->second.Scalar()));
      }
      ENFILADE_RETURN_IF_ERROR(Assign(values, options));
    }
  } catch (const YAML::Exception& error) {
    return InvalidArgument("door options: {}", error.what());
  }
  ENFILADE_RETURN_IF_ERROR(options.Validate());
  return options;
}

std::string FormatDoorOptions(const DoorOptions& options) {
  std::string text = fmt::format("preset: {}\n", NameOf(options.method));
  std::string group;
  VisitDoorOptions(options, [&](const std::string& name, const auto& value) {
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
