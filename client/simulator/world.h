// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "client/simulator/campus.h"

namespace enfilade::simulator {

// The distance to what a ray never meets, m.
constexpr double kNever = std::numeric_limits<double>::infinity();

// What a surface looks like: the texture with the seed of this very surface.
struct Paint {
  std::uint64_t seed = 0;
  float contrast = 1.0F;
  float brightness = 0.6F;
  float period = 0.0F;  // m; 0: none
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
  int gate = -1;  // a lift's door: there only while that lift (index) is on its way
};

// All upright surfaces of one level in a uniform grid, and the areas in a raster.
class LevelWorld {
 public:
  LevelWorld(std::vector<Face> faces, const std::vector<const Area*>& areas);

  const std::vector<Face>& faces() const { return faces_; }

  // Calls visit(t, face) for the faces that the ray from + t * direction meets within t < limit, nearest first, until
  // it returns false. Amanatides, Woo 1987. `gate`: the lift that is on its way, or -1.
  template <typename Visit>
  void Traverse(const Eigen::Vector2d& from, const Eigen::Vector2d& direction, double limit, int gate,
                Visit visit) const;

  // The area's index in the raster's list (25 cm cells: for surfaces' looks, not for truth), or -1.
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

// What of an area the cameras see beside its walls.
struct AreaLook {
  bool indoor = true;
  double ceiling = 3.0;  // m
  Paint floor;
  Paint above;  // the ceiling's
};

// A campus as its sensors see it. Immutable; any number of robots may look at once.
class World {
 public:
  // The campus must be valid.
  explicit World(Campus campus);
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  const Campus& campus() const { return campus_; }
  const LevelWorld& level(const std::string& id) const { return levels_.at(id); }
  const AreaLook& look(int area) const { return looks_[static_cast<std::size_t>(area)]; }

  // Where the people of a level stand, `seconds` after the start.
  struct Standing {
    Eigen::Vector2d at;
    double radius;
    double height;
  };
  std::vector<Standing> PeopleOn(const std::string& level, double seconds) const;

  // The number of a lift, as a gate.
  int GateOf(const std::string& lift) const;

 private:
  Campus campus_;
  std::map<std::string, LevelWorld> levels_;
  std::vector<AreaLook> looks_;  // as campus_.areas
};

// The first t >= 0 at which from + t * direction is within `radius` of `centre`; infinity where it never is.
double MeetCircle(const Eigen::Vector2d& from, const Eigen::Vector2d& direction, const Eigen::Vector2d& centre,
                  double radius);

template <typename Visit>
void LevelWorld::Traverse(const Eigen::Vector2d& from, const Eigen::Vector2d& direction, double limit, int gate,
                          Visit visit) const {
  // Enter the grid's box.
  double enter = 0.0;
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
    enter = std::max(enter, near);
    leave = std::min(leave, far);
  }
  if (!(enter < leave)) return;
  int cell[2];
  int step[2];
  double next[2];
  double every[2];
  const int size[2] = {width_, height_};
  for (int axis = 0; axis < 2; ++axis) {
    const double position = (from[axis] + enter * direction[axis] - low[axis]) / kCell;
    cell[axis] = std::clamp(static_cast<int>(std::floor(position)), 0, size[axis] - 1);
    step[axis] = direction[axis] > 0.0 ? 1 : -1;
    every[axis] = direction[axis] == 0.0 ? kNever : kCell / std::abs(direction[axis]);
    const double border = low[axis] + kCell * (cell[axis] + (step[axis] > 0 ? 1 : 0));
    next[axis] = direction[axis] == 0.0 ? kNever : (border - from[axis]) / direction[axis];
  }
  double begin = enter;
  std::pair<double, std::uint32_t> hits[64];
  while (begin < leave) {
    const int axis = next[0] < next[1] ? 0 : 1;
    const double end = std::min(next[axis], leave);
    const std::size_t index =
        static_cast<std::size_t>(cell[1]) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(cell[0]);
    std::size_t count = 0;
    for (std::uint32_t i = cell_begin_[index]; i < cell_begin_[index + 1] && count < 64; ++i) {
      const Face& face = faces_[cell_faces_[i]];
      if (face.gate >= 0 && face.gate != gate) continue;
      const Eigen::Vector2d edge = face.b - face.a;
      const double cross = direction.x() * edge.y() - direction.y() * edge.x();
      if (cross == 0.0) continue;
      const Eigen::Vector2d to = face.a - from;
      const double t = (to.x() * edge.y() - to.y() * edge.x()) / cross;
      // A face in several cells is met in the one where the meeting point lies.
      if (t < begin || t >= end) continue;
      const double along = (to.x() * direction.y() - to.y() * direction.x()) / cross;
      if (along < 0.0 || along > 1.0) continue;
      hits[count++] = {t, cell_faces_[i]};
    }
    for (std::size_t i = 1; i < count; ++i) {  // few: insertion sort
      for (std::size_t j = i; j > 0 && hits[j] < hits[j - 1]; --j) std::swap(hits[j], hits[j - 1]);
    }
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
