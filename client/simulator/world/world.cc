// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/world/world.h"

#include <algorithm>

#include "client/simulator/world/face_builder.h"
#include "core/base/noise.h"

namespace enfilade::simulator {
namespace {

constexpr std::uint64_t kFloor = 11;
constexpr std::uint64_t kCeiling = 12;

// Whether a face touches the box (separating axes: those of the box and the face's normal).
bool Touches(const Face& face, const Eigen::Vector2d& low, double side) {
  for (int axis = 0; axis < 2; ++axis) {
    if (std::max(face.a[axis], face.b[axis]) < low[axis]) return false;
    if (std::min(face.a[axis], face.b[axis]) > low[axis] + side) return false;
  }
  const Eigen::Vector2d edge = face.b - face.a;
  const Eigen::Vector2d normal(-edge.y(), edge.x());
  const Eigen::Vector2d middle = low + Eigen::Vector2d(side, side) / 2.0;
  const double reach = (std::abs(normal.x()) + std::abs(normal.y())) * side / 2.0;
  return std::abs(normal.dot(middle - face.a)) <= reach + 1e-9;
}

}  // namespace

LevelWorld::LevelWorld(std::vector<Face> faces, const std::vector<const Area*>& areas) : faces_(std::move(faces)) {
  Eigen::Vector2d low(0.0, 0.0);
  Eigen::Vector2d high(1.0, 1.0);
  bool first = true;
  const auto include = [&](const Eigen::Vector2d& point) {
    low = first ? point : Eigen::Vector2d(low.cwiseMin(point));
    high = first ? point : Eigen::Vector2d(high.cwiseMax(point));
    first = false;
  };
  for (const Face& face : faces_) {
    include(face.a);
    include(face.b);
  }
  for (const Area* area : areas) {
    for (const Eigen::Vector2d& corner : area->outline) include(corner);
  }
  origin_ = low - Eigen::Vector2d(0.5, 0.5);
  width_ = std::max(1, static_cast<int>(std::ceil((high.x() + 0.5 - origin_.x()) / kCell)));
  height_ = std::max(1, static_cast<int>(std::ceil((high.y() + 0.5 - origin_.y()) / kCell)));
  Index();
  Rasterise(areas);
}

void LevelWorld::Index() {
  const std::size_t cells = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> entries;  // cell, face
  for (std::uint32_t i = 0; i < faces_.size(); ++i) {
    const Face& face = faces_[i];
    const Eigen::Vector2d low = (face.a.cwiseMin(face.b) - origin_) / kCell;
    const Eigen::Vector2d high = (face.a.cwiseMax(face.b) - origin_) / kCell;
    for (int row = static_cast<int>(low.y() - 1e-6); row <= std::min(height_ - 1, static_cast<int>(high.y() + 1e-6));
         ++row) {
      for (int column = static_cast<int>(low.x() - 1e-6);
           column <= std::min(width_ - 1, static_cast<int>(high.x() + 1e-6)); ++column) {
        if (!Touches(face, origin_ + kCell * Eigen::Vector2d(column, row), kCell)) continue;
        entries.emplace_back(row * width_ + column, i);
      }
    }
  }
  std::sort(entries.begin(), entries.end());
  cell_begin_.assign(cells + 1, 0);
  for (const auto& [cell, face] : entries) {
    ++cell_begin_[cell + 1];
    cell_faces_.push_back(face);
  }
  for (std::size_t i = 0; i < cells; ++i) cell_begin_[i + 1] += cell_begin_[i];
}

void LevelWorld::Rasterise(const std::vector<const Area*>& areas) {
  const int per_cell = static_cast<int>(std::lround(kCell / kRasterCell));
  raster_width_ = width_ * per_cell;
  raster_height_ = height_ * per_cell;
  raster_.assign(static_cast<std::size_t>(raster_width_) * static_cast<std::size_t>(raster_height_), -1);
  for (std::size_t i = 0; i < areas.size(); ++i) {
    for (int row = 0; row < raster_height_; ++row) {
      for (int column = 0; column < raster_width_; ++column) {
        std::int16_t& cell = raster_[static_cast<std::size_t>(row) * static_cast<std::size_t>(raster_width_) +
                                     static_cast<std::size_t>(column)];
        if (cell >= 0) continue;
        const Eigen::Vector2d middle = origin_ + kRasterCell * Eigen::Vector2d(column + 0.5, row + 0.5);
        if (Contains(areas[i]->outline, middle)) cell = static_cast<std::int16_t>(i);
      }
    }
  }
}

World::World(Campus campus) : campus_(std::move(campus)) {
  for (std::size_t i = 0; i < campus_.areas.size(); ++i) {
    const Area& area = campus_.areas[i];
    AreaSurfaces surfaces;
    surfaces.indoor = area.indoor();
    surfaces.ceiling_height = area.wall_height;
    surfaces.floor = PaintOf(campus_, area.texture, kFloor);
    surfaces.ceiling = PaintOf(campus_, area.texture, kCeiling);
    surfaces.floor.contrast *= 0.6F;
    surfaces.ceiling.contrast *= 0.3F;
    surfaces_.push_back(surfaces);
  }
  for (const auto& [id, height] : campus_.levels) {
    // All areas, so that the raster's indices are the campus's; those of other levels contain no point.
    std::vector<Area> elsewhere(campus_.areas.size());
    std::vector<const Area*> areas;
    for (std::size_t i = 0; i < campus_.areas.size(); ++i) {
      areas.push_back(campus_.areas[i].level == id ? &campus_.areas[i] : &elsewhere[i]);
    }
    levels_.try_emplace(id, BuildFaces(campus_, id), areas);
  }
}

std::vector<World::PersonPosition> World::PeopleOn(const std::string& level, double seconds) const {
  std::vector<PersonPosition> result;
  for (const Person& person : campus_.people) {
    if (person.level != level) continue;
    double length = 0.0;
    for (std::size_t i = 1; i < person.path.size(); ++i) length += (person.path[i] - person.path[i - 1]).norm();
    Eigen::Vector2d at = person.path.front();
    if (length > 0.0) {
      double way = std::fmod(person.speed * (seconds + person.phase), 2.0 * length);
      if (way > length) way = 2.0 * length - way;
      for (std::size_t i = 1; i < person.path.size(); ++i) {
        const Eigen::Vector2d leg = person.path[i] - person.path[i - 1];
        at = person.path[i];
        if (way <= leg.norm()) {
          if (leg.norm() > 0.0) at = person.path[i - 1] + leg * (way / leg.norm());
          break;
        }
        way -= leg.norm();
      }
    }
    result.push_back({at, person.radius, person.height});
  }
  return result;
}

int World::GateOf(const std::string& lift) const {
  for (std::size_t i = 0; i < campus_.lifts.size(); ++i) {
    if (campus_.lifts[i].id == lift) return static_cast<int>(i);
  }
  return -1;
}

double IntersectCircle(const Eigen::Vector2d& from, const Eigen::Vector2d& direction, const Eigen::Vector2d& centre,
                       double radius) {
  const Eigen::Vector2d to = from - centre;
  const double a = direction.squaredNorm();
  const double b = to.dot(direction);
  const double c = to.squaredNorm() - radius * radius;
  const double root = b * b - a * c;
  if (c <= 0.0) return 0.0;
  if (root < 0.0 || b > 0.0) return kNoHit;
  return (-b - std::sqrt(root)) / a;
}

}  // namespace enfilade::simulator
