// SPDX-License-Identifier: Apache-2.0
#include "core/doors/door_options.h"

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/options/yaml_options.h"

namespace enfilade::doors {
namespace {

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
    return InvalidArgument("gap.min_width and max_width are {} and {} m: expected the former to be less, and up to 5 m",
                           gap.min_width, gap.max_width);
  }
  if (gap.look_ahead > gap.reach || gap.detour > gap.reach || gap.lag > gap.reach || gap.wall_reach > gap.reach) {
    return InvalidArgument("gap.look_ahead, detour, lag and wall_reach must not be beyond gap.reach, {} m", gap.reach);
  }
  if (derivative.front_sector > 180.0 || derivative.back_sector > 180.0) {
    return InvalidArgument("derivative.front_sector and back_sector must be at most 180 deg");
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
  constexpr std::string_view kWhat = "door options";
  DoorOptions options = base;
  ENFILADE_ASSIGN_OR_RETURN(const yaml_options::Values values, yaml_options::Load(yaml, kWhat));
  if (const auto preset = values.find("preset"); preset != values.end()) {
    ENFILADE_ASSIGN_OR_RETURN(options, DoorPreset(preset->second.Scalar()));
  }
  ENFILADE_RETURN_IF_ERROR(yaml_options::Assign(
      values, kWhat, [&](const auto& visitor) { VisitDoorOptions(options, visitor); }, {"preset"}));
  ENFILADE_RETURN_IF_ERROR(options.Validate());
  return options;
}

std::string FormatDoorOptions(const DoorOptions& options) {
  return fmt::format("preset: {}\n", NameOf(options.method)) +
         yaml_options::Format([&](const auto& visitor) { VisitDoorOptions(options, visitor); });
}

}  // namespace enfilade::doors
