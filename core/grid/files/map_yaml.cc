// SPDX-License-Identifier: Apache-2.0
#include "core/grid/files/map_yaml.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/options/yaml_document.h"

namespace enfilade::grid {
namespace {

constexpr std::size_t kMaxSize = 1 << 20;
constexpr std::array<std::string_view, 7> kKeys = {"image",           "resolution",  "origin", "negate",
                                                   "occupied_thresh", "free_thresh", "mode"};

using yaml_options::Location;
using yaml_options::ScalarAs;

constexpr std::string_view kWhat = "the map's YAML";

// "the map's YAML, line 3: ..."
template <typename... Args>
absl::Status Refused(const YAML::Node& where, fmt::format_string<Args...> format, Args&&... args) {
  return InvalidArgument("{}: {}", Location(kWhat, where.Mark()), fmt::format(format, std::forward<Args>(args)...));
}

absl::StatusOr<YAML::Node> Required(const YAML::Node& document, const std::string& key) {
  const YAML::Node node = document[key];
  if (!node.IsDefined() || node.IsNull()) return InvalidArgument("{} has no '{}'", kWhat, key);
  return node;
}

absl::StatusOr<double> NumberOf(const YAML::Node& node, const std::string& key) {
  const std::optional<double> value = ScalarAs<double>(node);
  if (!value.has_value()) {
    return Refused(node, "'{}' is not a number", key);
  }
  if (!std::isfinite(*value)) {
    return Refused(node, "'{}' is {}, which is not finite", key, *value);
  }
  return *value;
}

absl::StatusOr<double> Number(const YAML::Node& document, const std::string& key) {
  ENFILADE_ASSIGN_OR_RETURN(const YAML::Node node, Required(document, key));
  return NumberOf(node, key);
}

absl::StatusOr<std::string> ReadImage(const YAML::Node& document) {
  ENFILADE_ASSIGN_OR_RETURN(const YAML::Node node, Required(document, "image"));
  const std::optional<std::string> image = ScalarAs<std::string>(node);
  if (!image.has_value() || image->empty()) {
    return Refused(node, "'image' is not a file name");
  }
  return *image;
}

absl::StatusOr<double> ReadResolution(const YAML::Node& document) {
  ENFILADE_ASSIGN_OR_RETURN(const double resolution, Number(document, "resolution"));
  if (resolution > 0.0) return resolution;
  return Refused(document["resolution"], "'resolution' is {}: expected positive metres per pixel", resolution);
}

absl::StatusOr<Pose2> ReadOrigin(const YAML::Node& document) {
  ENFILADE_ASSIGN_OR_RETURN(const YAML::Node node, Required(document, "origin"));
  if (!node.IsSequence() || node.size() != 3) {
    return Refused(node, "'origin' is not a list of three numbers [x, y, yaw]");
  }
  Pose2 origin;
  ENFILADE_ASSIGN_OR_RETURN(origin.x, NumberOf(node[0], "origin[0]"));
  ENFILADE_ASSIGN_OR_RETURN(origin.y, NumberOf(node[1], "origin[1]"));
  ENFILADE_ASSIGN_OR_RETURN(origin.yaw, NumberOf(node[2], "origin[2]"));
  return origin;
}

absl::StatusOr<bool> ReadNegate(const YAML::Node& document) {
  ENFILADE_ASSIGN_OR_RETURN(const YAML::Node node, Required(document, "negate"));
  if (const std::optional<int> value = ScalarAs<int>(node)) return *value != 0;
  if (const std::optional<bool> value = ScalarAs<bool>(node)) return *value;
  return Refused(node, "'negate' is neither a whole number nor true or false");
}

absl::StatusOr<MapMode> ReadMode(const YAML::Node& document) {
  const YAML::Node node = document["mode"];
  if (!node.IsDefined()) return MapMode::kTrinary;
  const std::string mode = ScalarAs<std::string>(node).value_or("");
  if (mode == "trinary") return MapMode::kTrinary;
  if (mode == "scale") return MapMode::kScale;
  if (mode == "raw") return MapMode::kRaw;
  return Refused(node, "'mode' is '{}': expected trinary, scale or raw", mode);
}

std::vector<std::string> WarningsOf(const YAML::Node& document, const GreyInterpretation& by) {
  std::vector<std::string> warnings;
  for (const auto& entry : document) {
    const std::string key = ScalarAs<std::string>(entry.first).value_or("(not a word)");
    if (std::find(kKeys.begin(), kKeys.end(), key) != kKeys.end()) continue;
    warnings.push_back(fmt::format("{}: '{}' is unknown and ignored", Location(kWhat, entry.first.Mark()), key));
  }
  if (by.mode != MapMode::kRaw && by.free_thresh >= by.occupied_thresh) {
    warnings.push_back(
        fmt::format("the map's YAML: 'free_thresh' ({}) is not below 'occupied_thresh' ({}): greys that "
                    "meet both are treated as in map_server",
                    by.free_thresh, by.occupied_thresh));
  }
  return warnings;
}

absl::StatusOr<ParsedMapYaml> Read(const YAML::Node& document, MapDialect dialect) {
  if (!document.IsMap()) return InvalidArgument("the map's YAML is not a list of 'key: value' lines");
  ParsedMapYaml parsed;
  MapYaml& yaml = parsed.yaml;
  ENFILADE_ASSIGN_OR_RETURN(yaml.image, ReadImage(document));
  ENFILADE_ASSIGN_OR_RETURN(yaml.resolution, ReadResolution(document));
  ENFILADE_ASSIGN_OR_RETURN(yaml.origin, ReadOrigin(document));
  ENFILADE_ASSIGN_OR_RETURN(yaml.interpretation.free_thresh, Number(document, "free_thresh"));
  ENFILADE_ASSIGN_OR_RETURN(yaml.interpretation.occupied_thresh, Number(document, "occupied_thresh"));
  ENFILADE_ASSIGN_OR_RETURN(yaml.interpretation.mode, ReadMode(document));
  ENFILADE_ASSIGN_OR_RETURN(yaml.interpretation.negate, ReadNegate(document));
  yaml.interpretation.dialect = dialect;
  parsed.warnings = WarningsOf(document, yaml.interpretation);
  return parsed;
}

// The fewest digits that read back as the same double, always with a point: some YAML readers take 1e-05 for a word.
std::string Format(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find('.') != std::string::npos) return text;
  const std::size_t exponent = text.find('e');
  return text.insert(exponent == std::string::npos ? text.size() : exponent, ".0");
}

std::string_view NameOf(MapMode mode) {
  switch (mode) {
    case MapMode::kScale:
      return "scale";
    case MapMode::kRaw:
      return "raw";
    case MapMode::kTrinary:
      break;
  }
  return "trinary";
}

}  // namespace

absl::StatusOr<ParsedMapYaml> ParseMapYaml(std::string_view text, MapDialect dialect) {
  if (text.size() > kMaxSize)
    return InvalidArgument("the map's YAML is {} bytes long: expected at most {}", text.size(), kMaxSize);
  return yaml_options::ReadYaml(text, kWhat, [&](const YAML::Node& document) { return Read(document, dialect); });
}

std::string FormatMapYaml(const MapYaml& yaml) {
  const GreyInterpretation& by = yaml.interpretation;
  return fmt::format(
      "image: {}\n"
      "mode: {}\n"
      "resolution: {}\n"
      "origin: [{}, {}, {}]\n"
      "negate: {}\n"
      "occupied_thresh: {}\n"
      "free_thresh: {}\n",
      yaml.image, NameOf(by.mode), Format(yaml.resolution), Format(yaml.origin.x), Format(yaml.origin.y),
      Format(yaml.origin.yaw), by.negate ? 1 : 0, Format(by.occupied_thresh), Format(by.free_thresh));
}

}  // namespace enfilade::grid
