// SPDX-License-Identifier: Apache-2.0
#include "core/prior/formats/geojson_plan.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/geo/transverse_mercator.h"
#include "core/geometry/segments.h"
#include "core/prior/plan/plan_check.h"
#include "nlohmann/json.hpp"

namespace enfilade::prior {
namespace {

using Eigen::Vector2d;
using Json = nlohmann::json;

Json CoordinatesOf(const Vector2d& p) { return {p.x(), p.y()}; }

Json Feature(const char* kind, const char* type, Json coordinates) {
  return {{"type", "Feature"},
          {"properties", {{"kind", kind}}},
          {"geometry", {{"type", type}, {"coordinates", std::move(coordinates)}}}};
}

Json Ring(const std::vector<Vector2d>& outline) {
  Json ring = Json::array();
  for (const Vector2d& p : outline) ring.push_back(CoordinatesOf(p));
  ring.push_back(CoordinatesOf(outline.front()));
  return Json::array({std::move(ring)});
}

// Programs that edit tables write null where there is no value.
bool IsGiven(const Json& object, const char* name) { return object.contains(name) && !object[name].is_null(); }

template <typename T>
T ValueOf(const Json& object, const char* name, const T& otherwise) {
  return IsGiven(object, name) ? object[name].get<T>() : otherwise;
}

absl::Status TooManyWalls() { return ResourceExhausted("more than {} walls", kMostWalls); }

// Reads features into a plan; the first fault stays.
class PlanReader {
 public:
  // `sheet_only`: coordinates are the sheet's, also if no frame is named.
  PlanReader(const Json& document, bool sheet_only) : document_(document), sheet_only_(sheet_only) {}

  absl::StatusOr<PlanGraph> Read() {
    if (!document_.is_object() || !document_.contains("features") || !document_["features"].is_array()) {
      return InvalidArgument("not a GeoJSON FeatureCollection");
    }
    ENFILADE_RETURN_IF_ERROR(ReadFrame());
    std::size_t number = 0;
    for (const Json& feature : document_["features"]) {
      const absl::Status status = ReadTypedFeature(feature);
      if (!status.ok()) return WithContext(status, fmt::format("feature {}", number));
      if (plan_.walls.size() + named_.size() > kMostWalls) return TooManyWalls();
      ++number;
    }
    AddNamedWalls();
    ENFILADE_RETURN_IF_ERROR(Validate(plan_));
    return std::move(plan_);
  }

 private:
  enum class Frame { kSheet, kMetres, kLonLat };

  absl::Status ReadFrame() {
    const std::string frame = ValueOf<std::string>(document_, "frame", "");
    if (frame == "sheet" || (sheet_only_ && frame.empty())) {
      if (IsGiven(document_, "metres_per_unit")) plan_.metres_per_unit = document_["metres_per_unit"].get<double>();
      return IsGiven(document_, "H_sheet_photo") ? ReadHomography(document_["H_sheet_photo"]) : absl::OkStatus();
    }
    if (sheet_only_) return InvalidArgument("frame is \"{}\": expected sheet", frame);
    plan_.metres_per_unit = 1.0;
    if (frame == "metres") {
      frame_ = Frame::kMetres;
      return absl::OkStatus();
    }
    if (!frame.empty()) return InvalidArgument("frame is \"{}\": expected sheet or metres", frame);
    frame_ = Frame::kLonLat;
    return FindMiddle();
  }

  absl::Status ReadHomography(const Json& values) {
    if (!values.is_array() || values.size() != 9) return InvalidArgument("H_sheet_photo: expected nine numbers");
    plan_.H_sheet_photo.emplace();
    for (int i = 0; i < 9; ++i) (*plan_.H_sheet_photo)(i / 3, i % 3) = values[i].get<double>();
    return absl::OkStatus();
  }

  // The middle of all coordinates, for the projection.
  absl::Status FindMiddle() {
    Vector2d low = Vector2d::Constant(1e300), high = -low;
    std::vector<const Json*> nodes;
    for (const Json& feature : document_["features"]) {
      if (feature.is_object() && feature.contains("geometry") && feature["geometry"].is_object() &&
          feature["geometry"].contains("coordinates")) {
        nodes.push_back(&feature["geometry"]["coordinates"]);
      }
    }
    while (!nodes.empty()) {  // lists may be nested deeper than the stack is
      const Json& node = *nodes.back();
      nodes.pop_back();
      if (!node.is_array() || node.empty()) continue;
      if (!node[0].is_number()) {
        for (const Json& child : node) nodes.push_back(&child);
        continue;
      }
      if (node.size() < 2 || !node[1].is_number()) continue;
      const Vector2d p(node[0].get<double>(), node[1].get<double>());
      if (!(std::abs(p.x()) <= 180) || !(std::abs(p.y()) <= 89)) {
        return InvalidArgument(
            "longitude {} and latitude {} are out of range (coordinates in metres need \"frame\": \"metres\")", p.x(),
            p.y());
      }
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    if (low.x() <= high.x()) {
      const Vector2d middle = (low + high) / 2;
      projection_ = geo::TransverseMercator({middle.x(), middle.y()});
    }
    return absl::OkStatus();
  }

  absl::StatusOr<Vector2d> PointOf(const Json& coordinates) const {
    if (!coordinates.is_array() || coordinates.size() < 2 || !coordinates[0].is_number() ||
        !coordinates[1].is_number()) {
      return InvalidArgument("a position is not two numbers");
    }
    const Vector2d p(coordinates[0].get<double>(), coordinates[1].get<double>());
    if (!p.allFinite()) return InvalidArgument("a coordinate is not finite");
    if (frame_ == Frame::kSheet) return p;
    const Vector2d metres = frame_ == Frame::kMetres ? p : projection_.Forward({p.x(), p.y()});
    return Vector2d(metres.x(), -metres.y());
  }

  absl::StatusOr<std::vector<Vector2d>> PointsOf(const Json& list, std::size_t fewest) const {
    if (!list.is_array() || list.size() < fewest) return InvalidArgument("fewer than {} positions", fewest);
    std::vector<Vector2d> points;
    for (const Json& coordinates : list) {
      ENFILADE_ASSIGN_OR_RETURN(const Vector2d p, PointOf(coordinates));
      points.push_back(p);
    }
    return points;
  }

  absl::StatusOr<std::vector<Vector2d>> OutlineOf(const Json& rings) const {
    if (!rings.is_array() || rings.empty()) return InvalidArgument("a polygon without a ring");
    ENFILADE_ASSIGN_OR_RETURN(std::vector<Vector2d> outline, PointsOf(rings[0], 4));
    if ((outline.front() - outline.back()).norm() == 0) outline.pop_back();
    const std::size_t count = outline.size();
    for (std::size_t i = 0; count <= kMostChecked && i < count; ++i) {
      for (std::size_t j = i + 2; j < count; ++j) {
        if (i == 0 && j + 1 == count) continue;
        if (SegmentsCross(outline[i], outline[i + 1], outline[j], outline[(j + 1) % count])) {
          return InvalidArgument("the outline crosses itself between its corners {} and {}", i, j);
        }
      }
    }
    return outline;
  }
  static constexpr std::size_t kMostChecked = 2000;  // corners: the check takes their square

  // A member of another type than it should have is an exception.
  absl::Status ReadTypedFeature(const Json& feature) {
    try {
      return ReadFeature(feature);
    } catch (const Json::exception& error) {
      return InvalidArgument("{}", error.what());
    }
  }

  absl::Status ReadFeature(const Json& feature) {
    if (!feature.is_object()) return InvalidArgument("not an object");
    if (!feature.contains("geometry") || feature["geometry"].is_null()) return absl::OkStatus();
    const Json& geometry = feature["geometry"];
    if (!geometry.is_object() || !geometry.contains("coordinates"))
      return InvalidArgument("geometry has no coordinates");
    const Json properties = feature.value("properties", Json::object());
    const Json none = Json::object();
    return ReadGeometry(ValueOf<std::string>(geometry, "type", ""), geometry["coordinates"],
                        properties.is_object() ? properties : none);
  }

  absl::Status ReadGeometry(const std::string& type, const Json& coordinates, const Json& properties) {
    const std::string kind = ValueOf<std::string>(properties, "kind", "");
    if (type == "Point") {
      if (kind != "corner") return absl::OkStatus();
      ENFILADE_ASSIGN_OR_RETURN(const Vector2d p, PointOf(coordinates));
      plan_.corners.push_back({p});
      return absl::OkStatus();
    }
    if (type == "LineString") return ReadLine(kind, coordinates, properties);
    if (type == "Polygon") return ReadPolygon(kind, coordinates, properties);
    if (type == "MultiLineString" || type == "MultiPolygon") {
      if (!coordinates.is_array()) return InvalidArgument("coordinates is no list");
      for (const Json& part : coordinates) {
        ENFILADE_RETURN_IF_ERROR(ReadGeometry(type.substr(5), part, properties));
      }
    }
    return absl::OkStatus();
  }

  absl::Status ReadLine(const std::string& kind, const Json& coordinates, const Json& properties) {
    if (kind == "door") {
      ENFILADE_ASSIGN_OR_RETURN(const std::vector<Vector2d> points, PointsOf(coordinates, 2));
      plan_.doors.push_back(
          {.from = points.front(), .to = points.back(), .confidence = ValueOf(properties, "confidence", 1.0)});
      return absl::OkStatus();
    }
    if (!kind.empty() && kind != "wall") return absl::OkStatus();
    PlanWall wall{.thickness = ValueOf(properties, "thickness", 0.0),
                  .confidence = ValueOf(properties, "confidence", 1.0)};
    ENFILADE_ASSIGN_OR_RETURN(const std::vector<Vector2d> points, PointsOf(coordinates, 2));
    if (frame_ == Frame::kSheet && points.size() == 2 && IsGiven(properties, "from") && IsGiven(properties, "to")) {
      wall.from = CornerOf(properties["from"]);
      wall.to = CornerOf(properties["to"]);
      named_.push_back({plan_.walls.size(), wall, points});
      return absl::OkStatus();
    }
    AddWalls(points, wall);
    return absl::OkStatus();
  }

  // -1: no number of a corner. Other programs write 3 as 3.0, too.
  static int CornerOf(const Json& member) {
    const auto number = member.get<double>();
    const bool is_index = number >= 0 && number <= std::numeric_limits<int>::max() && number == std::floor(number);
    return is_index ? static_cast<int>(number) : -1;
  }

  // A wall that names its corners has them, if they are where its line ends; else the line counts, which a person may
  // have moved. The order of walls is that of their features.
  void AddNamedWalls() {
    const std::size_t named_corners = plan_.corners.size();
    const auto is_at = [&](int corner, const Vector2d& point) {
      return corner >= 0 && corner < static_cast<int>(named_corners) && plan_.corners[corner].point == point;
    };
    std::vector<PlanWall> others = std::move(plan_.walls);
    plan_.walls.clear();
    std::size_t next = 0;
    for (const NamedWall& named : named_) {
      for (; next < named.before; ++next) plan_.walls.push_back(others[next]);
      if (is_at(named.wall.from, named.line.front()) && is_at(named.wall.to, named.line.back())) {
        plan_.walls.push_back(named.wall);
      } else {
        AddWalls(named.line, named.wall);
      }
    }
    plan_.walls.insert(plan_.walls.end(), others.begin() + static_cast<std::ptrdiff_t>(next), others.end());
  }

  void AddWalls(const std::vector<Vector2d>& points, PlanWall wall) {
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      if (!((points[i + 1] - points[i]).norm() > 0)) continue;
      wall.from = static_cast<int>(plan_.corners.size());
      wall.to = wall.from + 1;
      plan_.corners.push_back({points[i]});
      plan_.corners.push_back({points[i + 1]});
      plan_.walls.push_back(wall);
    }
  }

  absl::Status ReadPolygon(const std::string& kind, const Json& rings, const Json& properties) {
    ENFILADE_ASSIGN_OR_RETURN(std::vector<Vector2d> outline, OutlineOf(rings));
    const std::string name = ValueOf<std::string>(properties, "name", "");
    if (kind == "room") {
      plan_.rooms.push_back({std::move(outline), name});
    } else if (kind == "shaft") {
      const bool stairs = ValueOf<std::string>(properties, "shaft", "lift") == "stairs";
      plan_.shafts.push_back({stairs ? ShaftKind::kStairs : ShaftKind::kLift, std::move(outline), name});
    } else if (kind.empty() || kind == "wall") {
      outline.push_back(outline.front());
      AddWalls(outline, {.confidence = ValueOf(properties, "confidence", 1.0)});
    }
    return absl::OkStatus();
  }

  struct NamedWall {
    std::size_t before = 0;  // how many of the other walls come before it
    PlanWall wall;
    std::vector<Vector2d> line;
  };

  const Json& document_;
  bool sheet_only_;
  std::vector<NamedWall> named_;
  Frame frame_ = Frame::kSheet;
  geo::TransverseMercator projection_;
  PlanGraph plan_;
};

absl::StatusOr<PlanGraph> ReadDocument(std::string_view text, bool sheet_only) {
  try {
    const Json document = Json::parse(text);
    return PlanReader(document, sheet_only).Read();
  } catch (const Json::exception& error) {
    return InvalidArgument("not a GeoJSON plan: {}", error.what());
  }
}

}  // namespace

std::string WriteGeoJsonPlan(const PlanGraph& plan) {
  Json features = Json::array();
  for (const PlanCorner& corner : plan.corners)
    features.push_back(Feature("corner", "Point", CoordinatesOf(corner.point)));
  for (const PlanWall& wall : plan.walls) {
    Json feature = Feature(
        "wall", "LineString",
        Json::array({CoordinatesOf(plan.corners[wall.from].point), CoordinatesOf(plan.corners[wall.to].point)}));
    feature["properties"].update(
        {{"from", wall.from}, {"to", wall.to}, {"thickness", wall.thickness}, {"confidence", wall.confidence}});
    features.push_back(std::move(feature));
  }
  for (const PlanDoor& door : plan.doors) {
    Json feature = Feature("door", "LineString", Json::array({CoordinatesOf(door.from), CoordinatesOf(door.to)}));
    feature["properties"]["confidence"] = door.confidence;
    features.push_back(std::move(feature));
  }
  for (const PlanRoom& room : plan.rooms) {
    features.push_back(Feature("room", "Polygon", Ring(room.outline)));
    features.back()["properties"]["name"] = room.name;
  }
  for (const PlanShaft& shaft : plan.shafts) {
    features.push_back(Feature("shaft", "Polygon", Ring(shaft.outline)));
    features.back()["properties"]["name"] = shaft.name;
    features.back()["properties"]["shaft"] = shaft.kind == ShaftKind::kLift ? "lift" : "stairs";
  }
  Json document = {{"type", "FeatureCollection"}, {"frame", "sheet"}, {"features", std::move(features)}};
  if (plan.metres_per_unit) document["metres_per_unit"] = *plan.metres_per_unit;
  if (plan.H_sheet_photo) {
    for (int i = 0; i < 9; ++i) document["H_sheet_photo"].push_back((*plan.H_sheet_photo)(i / 3, i % 3));
  }
  return document.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

absl::StatusOr<PlanGraph> ReadGeoJsonPlan(std::string_view text) { return ReadDocument(text, false); }

absl::StatusOr<PlanGraph> ReadEditedPlan(std::string_view text) { return ReadDocument(text, true); }

}  // namespace enfilade::prior
