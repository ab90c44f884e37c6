// SPDX-License-Identifier: Apache-2.0
#include "core/areas/area_geojson.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "core/base/error.h"
#include "core/base/excerpt.h"
#include "core/base/status_macros.h"
#include "nlohmann/json.hpp"

namespace enfilade::areas {
namespace {

using Eigen::Vector2d;
using Json = nlohmann::ordered_json;

constexpr const char* kFrame = "map_metres";
constexpr std::string_view kIdPrefix = "areas/";
constexpr std::size_t kMaxFeatures = 10'000;
constexpr std::size_t kMaxNameBytes = 800;  // 200 characters of UTF-8
// Also refuses absl's infinite times.
constexpr int kFirstYear = 1970;
constexpr int kLastYear = 2200;

std::string ToRfc3339(TimeNs time) {
  return absl::FormatTime(absl::RFC3339_full, absl::FromUnixNanos(time), absl::UTCTimeZone());
}

double SignedArea(const std::vector<Vector2d>& outline) {
  double area = 0.0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vector2d a = outline[i] - outline.front();
    const Vector2d b = outline[(i + 1) % outline.size()] - outline.front();
    area += a.x() * b.y() - a.y() * b.x();
  }
  return area / 2.0;
}

// Counter-clockwise and closed, as the RFC requires.
Json RingOf(const std::vector<Vector2d>& outline) {
  std::vector<Vector2d> corners = outline;
  if (SignedArea(corners) < 0.0) std::reverse(corners.begin() + 1, corners.end());
  Json ring = Json::array();
  for (const Vector2d& corner : corners) ring.push_back({corner.x(), corner.y()});
  ring.push_back({corners.front().x(), corners.front().y()});
  return ring;
}

Json FeatureOf(const NamedArea& named) {
  const MapArea& area = named.area;
  Json properties = {
      {"kind", std::string(NameOfKind(area.kind))}, {"name", area.display_name}, {"robot_types", area.robot_types}};
  if (area.kind == AreaKind::kSpeedLimit) properties["speed_limit_mps"] = area.speed_limit_mps;
  if (area.valid_from) properties["valid_from"] = ToRfc3339(*area.valid_from);
  if (area.valid_until) properties["valid_until"] = ToRfc3339(*area.valid_until);
  Json feature = {{"type", "Feature"}};
  if (!named.id.empty()) feature["id"] = std::string(kIdPrefix) + named.id.value();
  feature["geometry"] = {{"type", "Polygon"}, {"coordinates", Json::array({RingOf(area.outline)})}};
  feature["properties"] = std::move(properties);
  return feature;
}

// The member, or null if it is missing.
const Json& MemberOf(const Json& object, const char* name) {
  static const Json none;
  const auto found = object.find(name);
  return found == object.end() ? none : *found;
}

// The property's text; empty if it is missing or null.
absl::StatusOr<std::string> TextOf(const Json& properties, const char* name) {
  const Json& value = MemberOf(properties, name);
  if (value.is_null()) return std::string();
  if (!value.is_string()) return InvalidArgument("the property \"{}\" is not a text", name);
  return value.get<std::string>();
}

absl::StatusOr<std::optional<TimeNs>> TimeOf(const Json& properties, const char* name) {
  ENFILADE_ASSIGN_OR_RETURN(const std::string text, TextOf(properties, name));
  if (text.empty()) return std::optional<TimeNs>();
  absl::Time time;
  std::string why;
  if (!absl::ParseTime(absl::RFC3339_full, absl::string_view(text), &time, &why)) {
    return InvalidArgument("the property \"{}\" is \"{}\": expected a time as in 2026-01-31T08:00:00Z", name,
                           Excerpt(text, 100));
  }
  if (time < absl::FromCivil(absl::CivilSecond(kFirstYear), absl::UTCTimeZone()) ||
      time > absl::FromCivil(absl::CivilSecond(kLastYear), absl::UTCTimeZone())) {
    return InvalidArgument("the property \"{}\" is \"{}\": expected a time in the years {} to {}", name,
                           Excerpt(text, 100), kFirstYear, kLastYear);
  }
  return std::optional<TimeNs>(absl::ToUnixNanos(time));
}

absl::StatusOr<AreaKind> ReadKind(const Json& properties) {
  ENFILADE_ASSIGN_OR_RETURN(const std::string name, TextOf(properties, "kind"));
  if (const std::optional<AreaKind> kind = KindOfName(name)) return *kind;
  return InvalidArgument("the property \"kind\" is \"{}\": expected one of {}", Excerpt(name, 100),
                         fmt::join(KindNames(), ", "));
}

absl::StatusOr<std::vector<std::string>> ReadRobotTypes(const Json& properties) {
  const Json& list = MemberOf(properties, "robot_types");
  std::vector<std::string> types;
  if (list.is_null()) return types;
  if (!list.is_array()) return InvalidArgument("the property \"robot_types\" is not a list");
  if (list.size() > kMaxRobotTypes) {
    return InvalidArgument("the property \"robot_types\" has {} types: at most {} are allowed", list.size(),
                           kMaxRobotTypes);
  }
  for (const Json& type : list) {
    if (!type.is_string()) return InvalidArgument("the property \"robot_types\" has a type that is not a text");
    types.push_back(type.get<std::string>());
  }
  return types;
}

absl::StatusOr<std::vector<Vector2d>> ReadOutline(const Json& geometry) {
  if (!geometry.is_object() || MemberOf(geometry, "type") != "Polygon") {
    return InvalidArgument("the geometry is not a Polygon");
  }
  const Json& rings = MemberOf(geometry, "coordinates");
  if (!rings.is_array() || rings.size() != 1 || !rings[0].is_array()) {
    return InvalidArgument("the polygon has {} rings: expected one, as areas have no holes",
                           rings.is_array() ? rings.size() : 0);
  }
  const Json& ring = rings[0];
  if (ring.size() < kMinAreaCorners + 1 || ring.size() > kMaxAreaCorners + 1 || ring.front() != ring.back()) {
    return InvalidArgument("the ring has {} positions: expected {} to {}, the last one being the first one again",
                           ring.size(), kMinAreaCorners + 1, kMaxAreaCorners + 1);
  }
  std::vector<Vector2d> outline;
  for (std::size_t i = 0; i + 1 < ring.size(); ++i) {
    const Json& position = ring[i];
    if (!position.is_array() || position.size() < 2 || !position[0].is_number() || !position[1].is_number()) {
      return InvalidArgument("position {} is not two numbers", i);
    }
    outline.emplace_back(position[0].get<double>(), position[1].get<double>());
  }
  return outline;
}

absl::StatusOr<MapAreaId> ReadAreaId(const Json& feature) {
  const Json& id = MemberOf(feature, "id");
  if (!id.is_string()) return MapAreaId();  // a number, as other programs write, is none of ours
  const std::string text = id.get<std::string>();
  if (!std::string_view(text).starts_with(kIdPrefix)) return MapAreaId();
  const std::string value = text.substr(kIdPrefix.size());
  if (IsValidResourceId(value)) return MapAreaId(value);
  return InvalidArgument("the id is \"{}\": expected areas/ and 1 to 63 of a-z, 0-9 and \"-\"", Excerpt(text, 100));
}

absl::StatusOr<NamedArea> ReadFeature(const Json& feature) {
  if (!feature.is_object() || MemberOf(feature, "type") != "Feature") return InvalidArgument("not a Feature");
  const Json& properties = MemberOf(feature, "properties");
  if (!properties.is_object()) return InvalidArgument("it has no properties: \"kind\" is needed");
  NamedArea named;
  MapArea& area = named.area;
  ENFILADE_ASSIGN_OR_RETURN(named.id, ReadAreaId(feature));
  ENFILADE_ASSIGN_OR_RETURN(area.kind, ReadKind(properties));
  ENFILADE_ASSIGN_OR_RETURN(area.display_name, TextOf(properties, "name"));
  if (area.display_name.size() > kMaxNameBytes) {
    return InvalidArgument("the property \"name\" has {} bytes: at most {} are allowed", area.display_name.size(),
                           kMaxNameBytes);
  }
  if (area.display_name.empty()) area.display_name = std::string(NameOfKind(area.kind));
  ENFILADE_ASSIGN_OR_RETURN(area.robot_types, ReadRobotTypes(properties));
  if (const Json& speed = MemberOf(properties, "speed_limit_mps"); !speed.is_null()) {
    if (!speed.is_number()) return InvalidArgument("the property \"speed_limit_mps\" is not a number");
    area.speed_limit_mps = speed.get<double>();
  }
  ENFILADE_ASSIGN_OR_RETURN(area.valid_from, TimeOf(properties, "valid_from"));
  ENFILADE_ASSIGN_OR_RETURN(area.valid_until, TimeOf(properties, "valid_until"));
  ENFILADE_ASSIGN_OR_RETURN(area.outline, ReadOutline(MemberOf(feature, "geometry")));
  ENFILADE_RETURN_IF_ERROR(Validate(area));
  return named;
}

absl::StatusOr<std::vector<NamedArea>> ReadCollection(const Json& document) {
  if (!document.is_object() || MemberOf(document, "type") != "FeatureCollection" ||
      !MemberOf(document, "features").is_array()) {
    return InvalidArgument("not a GeoJSON FeatureCollection");
  }
  const Json& frame = MemberOf(document, "frame");
  if (!frame.is_null() && frame != kFrame) {
    return InvalidArgument("the member \"frame\" is {}: expected \"{}\", metres in the frame of one map",
                           Excerpt(frame.dump(), 100), kFrame);
  }
  const Json& features = MemberOf(document, "features");
  if (features.size() > kMaxFeatures) {
    return InvalidArgument("{} features: a map has at most {} areas", features.size(), kMaxFeatures);
  }
  std::vector<NamedArea> areas;
  for (const Json& feature : features) {
    absl::StatusOr<NamedArea> area = ReadFeature(feature);
    if (!area.ok()) return WithContext(area.status(), fmt::format("feature {}", areas.size()));
    areas.push_back(*std::move(area));
  }
  return areas;
}

}  // namespace

std::string WriteAreasGeoJson(const std::vector<NamedArea>& areas) {
  Json document = {{"type", "FeatureCollection"}, {"frame", kFrame}, {"features", Json::array()}};
  for (const NamedArea& area : areas) document["features"].push_back(FeatureOf(area));
  return document.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

absl::StatusOr<std::vector<NamedArea>> ReadAreasGeoJson(std::string_view text) {
  try {
    return ReadCollection(Json::parse(text));
  } catch (const Json::exception& error) {
    return InvalidArgument("not GeoJSON: {}", error.what());
  }
}

}  // namespace enfilade::areas
