// SPDX-License-Identifier: Apache-2.0
#include "core/prior/formats/building_file.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "Eigen/Geometry"
#include "core/base/error.h"
#include "core/geometry/convex_hull.h"
#include "core/options/yaml_document.h"
#include "fmt/format.h"

namespace enfilade::prior {
namespace {

using Points = std::vector<Eigen::Vector2d>;

// A level with what is needed to place parts of other levels on it.
struct LevelDrawing {
  BuildingLevel level;
  double elevation = 0.0;
  double scale = 0.0;  // m per unit of the file
  double up = -1.0;    // direction of the file's y
  std::map<std::string, Eigen::Vector2d> fiducials;

  Eigen::Vector2d ToMetres(double x, double y) const { return {scale * x, scale * up * y}; }
};

// Values of properties are [type, value].
std::string TextOf(const YAML::Node& property) {
  return property && property.IsSequence() && property.size() == 2 ? property[1].as<std::string>() : std::string();
}

class Parser {
 public:
  explicit Parser(const YAML::Node& root) : root_(root) {}

  absl::StatusOr<Building> Parse() {
    if (!root_.IsMap() || !root_["levels"] || !root_["levels"].IsMap()) {
      return InvalidArgument("not a building of Open-RMF's traffic editor: it has no levels");
    }
    if (root_["name"]) building_.name = root_["name"].as<std::string>();
    const bool metric =
        root_["coordinate_system"] && root_["coordinate_system"].as<std::string>() == "cartesian_meters";
    for (const auto& entry : root_["levels"]) {
      Try("levels " + entry.first.as<std::string>(),
          [&] { return ReadLevel(entry.first.as<std::string>(), entry.second, metric); });
    }
    std::sort(drawings_.begin(), drawings_.end(),
              [](const LevelDrawing& a, const LevelDrawing& b) { return a.elevation < b.elevation; });
    const auto below =
        std::count_if(drawings_.begin(), drawings_.end(), [](const LevelDrawing& d) { return d.elevation < -0.5; });
    for (std::size_t i = 0; i < drawings_.size(); ++i)
      drawings_[i].level.level = static_cast<int>(i) - static_cast<int>(below);
    if (root_["lifts"] && root_["lifts"].IsMap()) {
      for (const auto& entry : root_["lifts"]) {
        Try("lifts " + entry.first.as<std::string>(),
            [&] { return ReadLift(entry.first.as<std::string>(), entry.second); });
      }
    }
    for (LevelDrawing& drawing : drawings_) building_.levels.push_back(std::move(drawing.level));
    return std::move(building_);
  }

 private:
  // Adds a remark if `read` returns a reason why the item is refused.
  template <typename Read>
  void Try(const std::string& item, const Read& read) {
    item_ = item;
    std::optional<std::string> refusal;
    try {
      refusal = read();
    } catch (const YAML::Exception& error) {
      refusal = std::string("it does not have the traffic editor's format: ") + error.what();
    }
    if (refusal) building_.remarks.push_back({item, true, *refusal});
  }

  std::optional<std::string> ReadLevel(const std::string& name, const YAML::Node& node, bool metric) {
    LevelDrawing drawing;
    drawing.level.name = name;
    if (node["elevation"]) drawing.elevation = node["elevation"].as<double>();
    Points vertices;  // of the file
    if (node["vertices"]) {
      for (const auto& vertex : node["vertices"]) vertices.emplace_back(vertex[0].as<double>(), vertex[1].as<double>());
    }
    const auto is_finite = [](const Eigen::Vector2d& vertex) { return vertex.allFinite(); };
    if (!std::all_of(vertices.begin(), vertices.end(), is_finite)) return "it has a vertex that is not finite";
    drawing.scale = metric ? 1.0 : ScaleOf(node["measurements"], vertices);
    drawing.up = metric ? 1.0 : -1.0;
    drawing.level.metres_per_unit = drawing.scale;
    if (drawing.scale <= 0.0) return "it has no measured line, so its scale is unknown";
    if (node["fiducials"]) {
      for (const auto& fiducial : node["fiducials"]) {
        drawing.fiducials[fiducial[2].as<std::string>()] =
            drawing.ToMetres(fiducial[0].as<double>(), fiducial[1].as<double>());
      }
    }
    const auto point = [&](const YAML::Node& index) {
      const Eigen::Vector2d& vertex = vertices.at(index.as<std::size_t>());
      return drawing.ToMetres(vertex.x(), vertex.y());
    };
    try {
      const ConvexHull hull(CornersOf(node, point));
      if (hull.outline().size() >= 3) drawing.level.outline = hull.outline();
      if (node["doors"]) {
        for (const auto& door : node["doors"]) {
          const Eigen::Vector2d a = point(door[0]), b = point(door[1]), middle = (a + b) / 2;
          const double through = std::atan2(b.y() - a.y(), b.x() - a.x()) + M_PI / 2;
          drawing.level.doors.push_back(
              {TextOf(door[2]["name"]), {middle.x(), middle.y(), WrapAngle(through)}, (b - a).norm()});
        }
      }
      if (node["walls"]) {
        for (const auto& wall : node["walls"]) drawing.level.walls.push_back({point(wall[0]), point(wall[1])});
      }
    } catch (const std::out_of_range&) {
      return "it names a vertex that does not exist";
    }
    for (const BuildingWall& wall : drawing.level.walls) {
      if (!wall.a.allFinite() || !wall.b.allFinite()) return "it has a wall that is not finite in metres";
    }
    if (drawing.level.outline.empty())
      building_.remarks.push_back({item_, false, "it has neither floors nor walls, so it gets no outline"});
    drawings_.push_back(std::move(drawing));
    return std::nullopt;
  }

  template <typename PointAt>
  static Points CornersOf(const YAML::Node& node, const PointAt& point) {
    Points corners;
    if (node["floors"]) {
      for (const auto& floor : node["floors"]) {
        for (const auto& vertex : floor["vertices"]) corners.push_back(point(vertex));
      }
    }
    if (!corners.empty() || !node["walls"]) return corners;
    for (const auto& wall : node["walls"]) {
      corners.push_back(point(wall[0]));
      corners.push_back(point(wall[1]));
    }
    return corners;
  }

  // Metres per unit of the drawing, the mean over its measured lines; 0 if it has none.
  static double ScaleOf(const YAML::Node& measurements, const Points& vertices) {
    double sum = 0.0;
    int count = 0;
    for (std::size_t i = 0; measurements && i < measurements.size(); ++i) {
      const auto a = measurements[i][0].as<std::size_t>(), b = measurements[i][1].as<std::size_t>();
      if (a >= vertices.size() || b >= vertices.size()) continue;
      const double length = (vertices[b] - vertices[a]).norm();
      const double metres = std::atof(TextOf(measurements[i][2]["distance"]).c_str());
      if (!(length > 0.0 && metres > 0.0)) continue;
      sum += metres / length;
      ++count;
    }
    return count > 0 ? sum / count : 0.0;
  }

  std::optional<std::string> ReadLift(const std::string& name, const YAML::Node& node) {
    const auto reference = node["reference_floor_name"].as<std::string>();
    const auto home = std::find_if(drawings_.begin(), drawings_.end(),
                                   [&](const LevelDrawing& d) { return d.level.name == reference; });
    if (home == drawings_.end()) return "its reference floor \"" + reference + "\" was not imported";
    const Eigen::Vector2d position = home->ToMetres(node["x"].as<double>(), node["y"].as<double>());
    const Pose2 T_home_cabin{position.x(), position.y(), node["yaw"] ? node["yaw"].as<double>() : 0.0};
    BuildingLift lift;
    lift.name = name;
    ReadCabin(node, lift);
    for (std::size_t i = 0; i < drawings_.size(); ++i) {
      const std::string& level = drawings_[i].level.name;
      if (!node["level_doors"] || !node["level_doors"][level] || node["level_doors"][level].size() == 0) continue;
      const auto T_level_home = Align(*home, drawings_[i]);
      if (!T_level_home) {
        building_.remarks.push_back(
            {item_, false,
             fmt::format("\"{}\" and \"{}\" do not share two fiducials: the lift gets no stop there", level,
                         reference)});
        continue;
      }
      const Eigen::Vector2d place = *T_level_home * position;
      const double turn = std::atan2((*T_level_home).linear()(1, 0), (*T_level_home).linear()(0, 0));
      lift.stops.push_back({i, {place.x(), place.y(), WrapAngle(T_home_cabin.yaw + turn)}});
    }
    if (lift.stops.empty()) return "it does not stop at any imported level";
    building_.lifts.push_back(std::move(lift));
    return std::nullopt;
  }

  // Sizes are in metres, and doors stand along the cabin's sides.
  static void ReadCabin(const YAML::Node& node, BuildingLift& lift) {
    if (node["width"]) lift.width = node["width"].as<double>();
    if (node["depth"]) lift.depth = node["depth"].as<double>();
    if (!node["doors"] || !node["doors"].IsMap()) return;
    for (const auto& entry : node["doors"]) {
      const YAML::Node& door = entry.second;
      const double along = door["motion_axis_orientation"] ? door["motion_axis_orientation"].as<double>() : 0.0;
      lift.doors.push_back({entry.first.as<std::string>(),
                            {door["x"].as<double>(), door["y"].as<double>(), WrapAngle(along + M_PI / 2)},
                            door["width"].as<double>()});
    }
  }

  static std::optional<Eigen::Affine2d> Align(const LevelDrawing& from, const LevelDrawing& to) {
    if (&from == &to) return Eigen::Affine2d::Identity();
    Points sources, targets;
    for (const auto& [name, point] : from.fiducials) {
      const auto same = to.fiducials.find(name);
      if (same == to.fiducials.end()) continue;
      sources.push_back(point);
      targets.push_back(same->second);
    }
    const auto spread = [](const Points& points) {
      double largest = 0.0;
      for (const Eigen::Vector2d& point : points) largest = std::max(largest, (point - points.front()).norm());
      return largest;
    };
    constexpr double kApart = 0.1;  // m
    if (sources.size() < 2 || spread(sources) < kApart || spread(targets) < kApart) return std::nullopt;
    Eigen::Matrix2Xd source(2, sources.size()), target(2, targets.size());
    for (std::size_t i = 0; i < sources.size(); ++i) {
      source.col(static_cast<Eigen::Index>(i)) = sources[i];
      target.col(static_cast<Eigen::Index>(i)) = targets[i];
    }
    Eigen::Affine2d T_to_from;
    T_to_from.matrix() = Eigen::umeyama(source, target, true);
    return T_to_from;
  }

  const YAML::Node& root_;
  Building building_;
  std::vector<LevelDrawing> drawings_;
  std::string item_;
};

}  // namespace

absl::StatusOr<Building> ParseBuilding(const std::string& yaml) {
  return yaml_options::ReadYaml(yaml, "building.yaml", [](const YAML::Node& root) { return Parser(root).Parse(); });
}

}  // namespace enfilade::prior
