// SPDX-License-Identifier: Apache-2.0
#include "core/slam/slam_options_yaml.h"

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/options/yaml_options.h"
#include "core/slam/slam_option_names.h"

namespace enfilade::slam {
namespace {

absl::StatusOr<SlamOptions> ParseUnnamed(std::string_view yaml) {
  constexpr std::string_view kWhat = "slam options";
  SlamOptions options;
  ENFILADE_ASSIGN_OR_RETURN(const yaml_options::Values values, yaml_options::Load(yaml, kWhat));
  ENFILADE_RETURN_IF_ERROR(
      yaml_options::Assign(values, kWhat, [&](const auto& visitor) { VisitSlamOptions(options, visitor); }));
  ENFILADE_RETURN_IF_ERROR(options.Validate());
  return options;
}

}  // namespace

absl::StatusOr<SlamOptions> ParseSlamOptions(std::string_view yaml, std::string_view name) {
  absl::StatusOr<SlamOptions> options = ParseUnnamed(yaml);
  if (!options.ok() && !name.empty()) return WithContext(options.status(), std::string(name));
  return options;
}

std::string FormatSlamOptions(const SlamOptions& options) {
  return yaml_options::Format([&](const auto& visitor) { VisitSlamOptions(options, visitor); });
}

}  // namespace enfilade::slam
