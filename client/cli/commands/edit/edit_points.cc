// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/edit/edit_points.h"

#include <Eigen/Core>
#include <cmath>

#include "core/edit/integers.h"
#include "fmt/format.h"

namespace enfilade::cli {
namespace {

using edit::kUnitsPerCell;
using edit::LatticePoint;
using yaml_options::StrictMapping;

}  // namespace

LatticePoint EditPoints::PointOf(StrictMapping& of, const std::string& key, const YAML::Node& where, double x,
                                 double y) const {
  Eigen::Vector2d units = Eigen::Vector2d(x + 0.5, y + 0.5) * kUnitsPerCell;
  if (!in_cells_) {
    units = Inverse(lattice_.T_map_lattice) * Eigen::Vector2d(x, y) / lattice_.resolution * kUnitsPerCell;
  }
  if (!(units.cwiseAbs().maxCoeff() <= edit::kMaxCoordinate)) {
    of.Fail(where, fmt::format("{}.{}: ({}, {}) is more than {} cells from the lattice's origin", of.what(), key, x, y,
                               edit::kMaxCoordinate / kUnitsPerCell));
    return {};
  }
  return {static_cast<std::int32_t>(std::lround(units.x())), static_cast<std::int32_t>(std::lround(units.y()))};
}

LatticePoint EditPoints::One(StrictMapping& of, const std::string& key, const YAML::Node& value) const {
  const std::vector<double> numbers = of.NumbersOf(value, key, 2);
  return PointOf(of, key, value, numbers[0], numbers[1]);
}

std::vector<LatticePoint> EditPoints::Many(StrictMapping& of, const std::string& key, const YAML::Node& value) const {
  std::vector<LatticePoint> points;
  if (!value.IsSequence()) {
    of.Fail(value, fmt::format("{}.{}: expected a list of points [x, y]", of.what(), key));
    return points;
  }
  for (const YAML::Node& point : value) points.push_back(One(of, key, point));
  return points;
}

std::vector<LatticePoint> EditPoints::Rectangle(StrictMapping& of, const std::string& key,
                                                const YAML::Node& value) const {
  if (!value.IsSequence() || value.size() != 2) {
    of.Fail(value, fmt::format("{}.{}: expected two opposite corners [[x, y], [x, y]]", of.what(), key));
    return {};
  }
  const std::vector<double> a = of.NumbersOf(value[0], key, 2);
  const std::vector<double> b = of.NumbersOf(value[1], key, 2);
  return {PointOf(of, key, value, a[0], a[1]), PointOf(of, key, value, b[0], a[1]), PointOf(of, key, value, b[0], b[1]),
          PointOf(of, key, value, a[0], b[1])};
}

std::int32_t EditPoints::Length(StrictMapping& of, const std::string& key) const {
  const double cells = in_cells_ ? 1.0 : lattice_.resolution;  // of the unit, in one cell
  const auto length = of.Required<double>(key);
  const double units = std::round(length / cells * kUnitsPerCell);
  if (units >= 0.0 && units <= edit::kMaxRadius) return static_cast<std::int32_t>(units);
  of.Fail(of.Find(key), fmt::format("{}.{} is {}: expected 0 to {}", of.what(), key, length,
                                    cells * (edit::kMaxRadius / kUnitsPerCell)));
  return 0;
}

edit::CellBox BoxAround(const std::vector<LatticePoint>& points) {
  edit::CellBox box;
  for (const LatticePoint& point : points) {
    box.Include(static_cast<int>(edit::FloorDiv(point.x, kUnitsPerCell)),
                static_cast<int>(edit::FloorDiv(point.y, kUnitsPerCell)));
  }
  return box;
}

}  // namespace enfilade::cli
