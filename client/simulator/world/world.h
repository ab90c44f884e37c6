// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "client/simulator/campus/campus.h"

namespace enfilade::simulator {

// The distance of a ray that hits nothing, m.
constexpr double kNoHit = std::numeric_limits<double>::infinity();

// The appearance of one surface: its texture, with a seed that belongs to this surface only.
struct Paint {
  std::uint64_t seed = 0;
  float contrast = 1.0F;
  float brightness = 0.6F;
  float period = 0.0F;  // m; 0: the pattern does not repeat
};

// An upright rectangle.
struct Face {
  Eigen::Vector2d a;
  Eigen::Vector2d b;
  double bottom = 0.0;
  double top = 3.0;
  double u_a = 0.0;  // m, the texture's coordinate at a and b
  double u_b = 0.0;
  Paint paint;
  bool glass = false;
  int gate = -1;  // the door of a lift (its index): there only while that lift moves
};

// All upright surfaces of one level in a uniform grid, and the areas in a raster.
class LevelWorld {
 public:
  LevelWorld(std::vector<Face> faces, const std::vector<const Area*>& areas);

  const std::vector<Face>& faces() const { return faces_; }

  // Calls visit(t, face) for the faces that the ray from + t * direction hits at t < limit, nearest first, until it
  // returns false (Amanatides, Woo 1987). `gate`: the lift that moves, or -1.
  template <typename Visit>
  void Traverse(const Eigen::Vector2d& from, const Eigen::Vector2d& direction, double limit, int gate,
                Visit visit) const;

  // The index of the area at a point, or -1. Accurate to 25 cm: good enough for appearance, not for ground truth.
  int RasterAreaAt(double x, double y) const {
    const int column = static_cast<int>(std::floor((x - origin_.x()) / kRasterCell));
    const int row = static_cast<int>(std::floor((y - origin_.y()) / kRasterCell));
    if (column < 0 || row < 0 || column >= raster_width_ || row >= raster_height_) return -1;
    return raster_[static_cast<std::size_t>(row) * static_cast<std::size_t>(raster_width_) +
                   static_cast<std::size_t>(column)];
  }
  Eigen::Vector2d lower() const { return origin_; }
  Eigen::Vector2d upper() const { return origin_ + kCell * Eigen::Vector2d(width_, height_); }

 private:
  static constexpr double kCell = 1.0;         // m
  static constexpr double kRasterCell = 0.25;  // m

  struct Ray {
    const Eigen::Vector2d& from;
    const Eigen::Vector2d& direction;
    int gate;
  };
  using Hits = std::array<std::pair<double, std::uint32_t>, 64>;  // t, index of the face

  // The faces of one cell that the ray hits at begin <= t < end, nearest first.
  std::size_t HitsInCell(std::size_t cell, const Ray& ray, double begin, double end, Hits& hits) const;
  void Index();
  void Rasterise(const std::vector<const Area*>& areas);

  std::vector<Face> faces_;
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  int width_ = 0;
  int height_ = 0;
  std::vector<std::uint32_t> cell_begin_;  // into cell_faces_, one more than there are cells
  std::vector<std::uint32_t> cell_faces_;
  int raster_width_ = 0;
  int raster_height_ = 0;
  std::vector<std::int16_t> raster_;
};

// The floor and the ceiling of an area.
struct AreaSurfaces {
  bool indoor = true;
  double ceiling_height = 3.0;  // m
  Paint floor;
  Paint ceiling;
};

// A campus as sensors see it. Immutable, so any number of robots can use it at the same time.
class World {
 public:
  // The campus must be valid.
  explicit World(Campus campus);
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  const Campus& campus() const { return campus_; }
  const LevelWorld& level(const std::string& id) const { return levels_.at(id); }
  const AreaSurfaces& surfaces(int area) const { return surfaces_[static_cast<std::size_t>(area)]; }

  // Where the people on a level are, `seconds` after the start.
  struct PersonPosition {
    Eigen::Vector2d at;
    double radius;
    double height;
  };
  std::vector<PersonPosition> PeopleOn(const std::string& level, double seconds) const;

  // The index of a lift, for Face::gate; -1 if there is none.
  int GateOf(const std::string& lift) const;

 private:
  Campus campus_;
  std::map<std::string, LevelWorld> levels_;
  std::vector<AreaSurfaces> surfaces_;  // as campus_.areas
};

// The first t >= 0 at which from + t * direction is within `radius` of `centre`; kNoHit if it never is.
double IntersectCircle(const Eigen::Vector2d& from, const Eigen::Vector2d& direction, const Eigen::Vector2d& centre,
                       double radius);

inline std::size_t LevelWorld::HitsInCell(std::size_t cell, const Ray& ray, double begin, double end,
                                          Hits& hits) const {
  std::size_t count = 0;
  for (std::uint32_t i = cell_begin_[cell]; i < cell_begin_[cell + 1] && count < hits.size(); ++i) {
    const Face& face = faces_[cell_faces_[i]];
    if (face.gate >= 0 && face.gate != ray.gate) continue;
    const Eigen::Vector2d edge = face.b - face.a;
    const double cross = ray.direction.x() * edge.y() - ray.direction.y() * edge.x();
    if (cross == 0.0) continue;
    const Eigen::Vector2d to = face.a - ray.from;
    const double t = (to.x() * edge.y() - to.y() * edge.x()) / cross;
    // A face in several cells is hit in the cell that contains the hit.
    if (t < begin || t >= end) continue;
    const double along = (to.x() * ray.direction.y() - to.y() * ray.direction.x()) / cross;
    if (along < 0.0 || along > 1.0) continue;
    hits[count++] = {t, cell_faces_[i]};
  }
  for (std::size_t i = 1; i < count; ++i) {  // few: insertion sort
    for (std::size_t j = i; j > 0 && hits[j] < hits[j - 1]; --j) std::swap(hits[j], hits[j - 1]);
  }
  return count;
}

template <typename Visit>
void LevelWorld::Traverse(const Eigen::Vector2d& from, const Eigen::Vector2d& direction, double limit, int gate,
                          Visit visit) const {
  // Clip the ray to the grid.
  double begin = 0.0;
  double leave = limit;
  const Eigen::Vector2d low = lower();
  const Eigen::Vector2d high = upper();
  for (int axis = 0; axis < 2; ++axis) {
    if (direction[axis] == 0.0) {
      if (from[axis] < low[axis] || from[axis] >= high[axis]) return;
      continue;
    }
    double near = (low[axis] - from[axis]) / direction[axis];
    double far = (high[axis] - from[axis]) / direction[axis];
    if (near > far) std::swap(near, far);
    begin = std::max(begin, near);
    leave = std::min(leave, far);
  }
  if (!(begin < leave)) return;
  int cell[2];
  int step[2];
  double next[2];   // t at the border to the next cell
  double every[2];  // t from border to border
  const int size[2] = {width_, height_};
  for (int axis = 0; axis < 2; ++axis) {
    const double position = (from[axis] + begin * direction[axis] - low[axis]) / kCell;
    cell[axis] = std::clamp(static_cast<int>(std::floor(position)), 0, size[axis] - 1);
    step[axis] = direction[axis] > 0.0 ? 1 : -1;
    every[axis] = direction[axis] == 0.0 ? kNoHit : kCell / std::abs(direction[axis]);
    const double border = low[axis] + kCell * (cell[axis] + (step[axis] > 0 ? 1 : 0));
    next[axis] = direction[axis] == 0.0 ? kNoHit : (border - from[axis]) / direction[axis];
  }
  Hits hits;
  while (begin < leave) {
    const int axis = next[0] < next[1] ? 0 : 1;
    const double end = std::min(next[axis], leave);
    const std::size_t index =
        static_cast<std::size_t>(cell[1]) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(cell[0]);
    const std::size_t count = HitsInCell(index, {from, direction, gate}, begin, end, hits);
    for (std::size_t i = 0; i < count; ++i) {
      if (!visit(hits[i].first, faces_[hits[i].second])) return;
    }
    begin = end;
    cell[axis] += step[axis];
    next[axis] += every[axis];
    if (cell[axis] < 0 || cell[axis] >= size[axis]) return;
  }
}

}  // namespace enfilade::simulator
