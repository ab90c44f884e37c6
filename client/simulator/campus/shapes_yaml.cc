// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/campus/shapes_yaml.h"

#include <cstddef>
#include <utility>

#include "core/geometry/pose2.h"

namespace enfilade::simulator {

using yaml_options::StrictMapping;

Eigen::Vector2d Point(StrictMapping& map, const std::string& key) {
  const std::vector<double> numbers = map.Numbers(key, 2);
  return {numbers[0], numbers[1]};
}

std::vector<Eigen::Vector2d> Points(StrictMapping& map, const std::string& key) {
  std::vector<Eigen::Vector2d> points;
  const YAML::Node list = map.Find(key);
  if (!list.IsDefined() || !list.IsSequence()) {
    map.Fail(list, map.what() + "." + key + ": expected a list of points");
    return points;
  }
  for (const YAML::Node& point : list) {
    const std::vector<double> numbers = map.NumbersOf(point, key, 2);
    points.emplace_back(numbers[0], numbers[1]);
  }
  return points;
}

std::vector<Eigen::Vector2d> Outline(StrictMapping& map) {
  if (map.Has("polygon")) return Points(map, "polygon");
  const std::vector<double> r = map.Numbers("rect", 4);
  if (r[2] <= 0.0 || r[3] <= 0.0) map.Fail(map.Find("rect"), map.what() + ".rect: width and height must be positive");
  return RectangleOutline(r[0], r[1], r[2], r[3], map.Number("yaw_deg", 0.0, -360.0, 360.0) * kDegree);
}

void PlaceDoor(StrictMapping& map, const Area& area, Door& door) {
  using Side = std::pair<std::size_t, std::size_t>;  // corners of the outline
  const Side south(0, 1);
  const Side side =
      map.Choice<Side>("side", {{"south", south}, {"east", {1, 2}}, {"north", {3, 2}}, {"west", {0, 3}}}, south);
  const double width = map.Number("width", 1.0, 0.1, 100.0);
  if (area.outline.size() != 4) {
    return map.Fail(map.Find("side"), map.what() + ": only rectangles have sides; use from and to under doors");
  }
  const Eigen::Vector2d begin = area.outline[side.first];
  const Eigen::Vector2d end = area.outline[side.second];
  const double length = (end - begin).norm();
  const double at = map.Number("at", length / 2.0, 0.0, length);
  if (at - width / 2.0 < -1e-9 || at + width / 2.0 > length + 1e-9) {
    map.Fail(map.Find("at"), map.what() + ": the door extends beyond its side");
  }
  const Eigen::Vector2d along = (end - begin) / length;
  door.a = begin + (at - width / 2.0) * along;
  door.b = begin + (at + width / 2.0) * along;
}

}  // namespace enfilade::simulator
