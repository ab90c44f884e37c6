// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/world/face_builder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "client/simulator/world/door_gaps.h"
#include "core/base/noise.h"

namespace enfilade::simulator {
namespace {

struct WallLine {
  Eigen::Vector2d p;
  Eigen::Vector2d q;
  double bottom;
  double top;
  double thickness;
  bool glass;
  std::string texture;
};

// How high a surface reaches and what it looks like.
struct Surface {
  double bottom = 0.0;
  double top = 0.0;
  bool glass = false;
  std::string texture = {};  // empty: that of the area in front of it
  int gate = -1;
};

class FaceBuilder {
 public:
  FaceBuilder(const Campus& campus, const std::string& level) : campus_(campus), level_(level) {}

  std::vector<Face> Build() && {
    for (const Area& area : campus_.areas) {
      if (area.level == level_ && area.walled) AddAreaWalls(area);
    }
    for (const Wall& wall : campus_.walls) {
      if (wall.level != level_) continue;
      for (std::size_t i = 0; i + 1 < wall.points.size(); ++i) {
        AddWall({wall.points[i], wall.points[i + 1], wall.bottom, wall.top, wall.thickness, wall.glass, wall.texture});
      }
    }
    for (const Door& door : campus_.doors) {
      if (door.level == level_) AddDoor(door);
    }
    for (const Box& box : campus_.boxes) {
      if (box.level == level_) AddPrism(box.outline, {box.bottom, box.top, false, box.texture});
    }
    return std::move(faces_);
  }

 private:
  void AddAreaWalls(const Area& area) {
    for (std::size_t i = 0; i < area.outline.size(); ++i) {
      AddWall({area.outline[i], area.outline[(i + 1) % area.outline.size()], 0.0, area.wall_height,
               campus_.wall_thickness, false, ""});
    }
  }

  // The wall without its doors, and the lintels above them.
  void AddWall(const WallLine& wall) {
    const double length = (wall.q - wall.p).norm();
    if (length < 1e-9) return;
    const Eigen::Vector2d on = (wall.q - wall.p) / length;
    std::vector<std::pair<double, double>> gaps;
    for (const DoorGap& gap : DoorGapsOf(campus_, level_, wall.p, wall.q)) {
      gaps.emplace_back(gap.begin, gap.end);
      if (gap.door->height < wall.top) AddBlock(wall, on, gap.begin, gap.end, gap.door->height);
    }
    // The wall's texture may change at another area's corner: a new piece begins there.
    for (const Area& area : campus_.areas) {
      for (const Eigen::Vector2d& corner : area.outline) {
        const Eigen::Vector2d to = corner - wall.p;
        const double along = on.dot(to);
        if (area.level != level_ || along < 0.01 || along > length - 0.01) continue;
        if (std::abs(on.x() * to.y() - on.y() * to.x()) < 0.01) gaps.emplace_back(along, along);
      }
    }
    std::sort(gaps.begin(), gaps.end());
    const double half = wall.thickness / 2.0;
    double begin = -half;  // corners are filled
    for (const auto& [gap_begin, gap_end] : gaps) {
      if (gap_begin > begin) AddBlock(wall, on, begin, gap_begin, wall.bottom);
      begin = std::max(begin, gap_end);
    }
    if (begin < length + half) AddBlock(wall, on, begin, length + half, wall.bottom);
  }

  void AddBlock(const WallLine& wall, const Eigen::Vector2d& on, double begin, double end, double bottom) {
    const Eigen::Vector2d from = wall.p + begin * on;
    const Eigen::Vector2d to = wall.p + end * on;
    const Surface surface{bottom, wall.top, wall.glass, wall.texture};
    if (wall.thickness <= 0.0) return AddFace(from, to, surface);
    const Eigen::Vector2d aside = Eigen::Vector2d(-on.y(), on.x()) * (wall.thickness / 2.0);
    AddPrism({from - aside, to - aside, to + aside, from + aside}, surface);
  }

  void AddDoor(const Door& door) {
    if (door.state != DoorState::kOpen) {
      AddFace(door.a, door.b, {0.0, door.height, door.state == DoorState::kGlass});
    } else if (door.leaf) {
      const Eigen::Vector2d gap = door.b - door.a;
      const double c = std::cos(*door.leaf);
      const double s = std::sin(*door.leaf);
      const Eigen::Vector2d leaf(c * gap.x() - s * gap.y(), s * gap.x() + c * gap.y());
      AddFace(door.a, door.a + leaf, {0.0, door.height});
    }
    for (std::size_t i = 0; i < campus_.lifts.size(); ++i) {
      if (door.id == campus_.lifts[i].id + "/" + level_) {
        AddFace(door.a, door.b, {.top = door.height, .gate = static_cast<int>(i)});
      }
    }
  }

  void AddPrism(const std::vector<Eigen::Vector2d>& outline, const Surface& surface) {
    for (std::size_t i = 0; i < outline.size(); ++i) {
      AddFace(outline[i], outline[(i + 1) % outline.size()], surface);
    }
  }

  // From `a` to `b`; its front is on the right-hand side.
  void AddFace(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Surface& surface) {
    Eigen::Vector2d on = b - a;
    if (on.norm() < 1e-9 || surface.top <= surface.bottom) return;
    on.normalize();
    const Eigen::Vector2d out(on.y(), -on.x());
    std::string texture = surface.texture;
    if (texture.empty()) {
      const Area* area = campus_.AreaAt(level_, (a + b) / 2.0 + 0.1 * out);
      if (!area) area = campus_.AreaAt(level_, (a + b) / 2.0 - 0.1 * out);
      if (area) texture = area->texture;
    }
    // A wall between two rooms may be built twice: its appearance depends only on where it is.
    Eigen::Vector2d axis = on;
    if (axis.x() < -1e-9 || (axis.x() <= 1e-9 && axis.y() < 0.0)) axis = -axis;
    const auto rounded = [](double value) { return static_cast<std::uint64_t>(std::llround(value * 50.0)); };
    const double offset = axis.x() * a.y() - axis.y() * a.x();
    const auto found = campus_.textures.find(texture);
    const bool repeats = found != campus_.textures.end() && found->second.period > 0.0;
    std::uint64_t salt = Mix(rounded(axis.x()), rounded(axis.y()), rounded(out.x() + 3.0 * out.y()));
    if (!repeats) salt = Mix(salt, rounded(offset));
    Face face;
    face.a = a;
    face.b = b;
    face.bottom = surface.bottom;
    face.top = surface.top;
    face.u_a = axis.dot(a);
    face.u_b = axis.dot(b);
    face.glass = surface.glass;
    face.gate = surface.gate;
    face.paint = PaintOf(campus_, texture, salt);
    faces_.push_back(face);
  }

  const Campus& campus_;
  const std::string& level_;
  std::vector<Face> faces_;
};

}  // namespace

Paint PaintOf(const Campus& campus, const std::string& texture, std::uint64_t salt) {
  const auto found = campus.textures.find(texture);
  const Texture look = found == campus.textures.end() ? Texture{} : found->second;
  Paint paint;
  paint.seed = Mix(campus.texture_seed, look.seed, salt);
  paint.contrast = static_cast<float>(look.contrast);
  paint.brightness = static_cast<float>(look.brightness);
  paint.period = static_cast<float>(look.period);
  return paint;
}

std::vector<Face> BuildFaces(const Campus& campus, const std::string& level) {
  return FaceBuilder(campus, level).Build();
}

}  // namespace enfilade::simulator
