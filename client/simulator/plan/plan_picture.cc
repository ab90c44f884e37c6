// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/plan/plan_picture.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/grid/files/rgb_image.h"

namespace enfilade::simulator {
namespace {

constexpr grid::Rgb kNothing{205, 212, 218};
constexpr grid::Rgb kIndoor{255, 255, 255};
constexpr grid::Rgb kOutdoor{226, 240, 217};
constexpr grid::Rgb kWall{40, 40, 40};
constexpr grid::Rgb kGlass{100, 180, 230};
constexpr grid::Rgb kOpenDoor{240, 160, 40};
constexpr grid::Rgb kLow{150, 120, 90};
constexpr grid::Rgb kPeople{190, 190, 190};
constexpr grid::Rgb kDrives[] = {grid::kBlue, grid::kRed, grid::kGreen, {148, 103, 189}, {23, 190, 207}};
constexpr double kLargest = 1600.0;  // pixels

class Plan {
 public:
  Plan(const World& world, const std::string& id)
      : level_(world.level(id)),
        scale_(std::min(40.0, kLargest / (level_.upper() - level_.lower()).maxCoeff())),
        image_(static_cast<int>(scale_ * (level_.upper() - level_.lower()).x()) + 1,
               static_cast<int>(scale_ * (level_.upper() - level_.lower()).y()) + 1, kNothing) {
    for (int y = 0; y < image_.height; ++y) {
      for (int x = 0; x < image_.width; ++x) {
        const Eigen::Vector2d at(level_.lower().x() + x / scale_, level_.upper().y() - y / scale_);
        const int area = level_.RasterAreaAt(at.x(), at.y());
        if (area < 0) continue;
        const grid::Rgb color = world.surfaces(area).indoor ? kIndoor : kOutdoor;
        std::copy(color.begin(), color.end(),
                  image_.samples.begin() + 3 * (static_cast<std::ptrdiff_t>(y) * image_.width + x));
      }
    }
  }
  void Line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, grid::Rgb color, int thickness) {
    grid::DrawLine(image_, Pixel(a), Pixel(b), color, thickness);
  }
  void Cross(const Eigen::Vector2d& at, grid::Rgb color) {
    constexpr double kArm = 0.25;
    Line(at + Eigen::Vector2d(-kArm, -kArm), at + Eigen::Vector2d(kArm, kArm), color, 2);
    Line(at + Eigen::Vector2d(-kArm, kArm), at + Eigen::Vector2d(kArm, -kArm), color, 2);
  }
  const LevelWorld& level() const { return level_; }
  absl::StatusOr<std::string> Png() const { return grid::EncodePng(image_); }

 private:
  Eigen::Vector2d Pixel(const Eigen::Vector2d& p) const {
    return {(p.x() - level_.lower().x()) * scale_, (level_.upper().y() - p.y()) * scale_};
  }

  const LevelWorld& level_;
  double scale_;  // pixels per metre
  grid::RgbImage image_;
};

}  // namespace

absl::StatusOr<std::string> DrawPlan(const World& world, const std::string& level,
                                     const std::map<std::string, GroundTruth>& drives) {
  Plan plan(world, level);
  for (const Person& person : world.campus().people) {
    if (person.level != level) continue;
    for (std::size_t i = 1; i < person.path.size(); ++i) plan.Line(person.path[i - 1], person.path[i], kPeople, 1);
  }
  for (const Face& face : plan.level().faces()) {
    if (face.bottom >= 1.0) continue;  // lintels
    plan.Line(face.a, face.b, face.glass ? kGlass : face.top < 1.5 ? kLow : kWall, 1);
  }
  for (const Door& door : world.campus().doors) {
    if (door.level == level && door.state == DoorState::kOpen && !door.opening) plan.Line(door.a, door.b, kOpenDoor, 1);
  }
  std::size_t index = 0;
  for (const auto& [robot, truth] : drives) {
    const grid::Rgb color = kDrives[index++ % std::size(kDrives)];
    for (std::size_t i = 1; i < truth.poses.size(); ++i) {
      if (truth.poses[i].level != level || truth.poses[i - 1].level != level) continue;
      plan.Line(truth.poses[i - 1].T_campus_robot.translation(), truth.poses[i].T_campus_robot.translation(), color, 1);
    }
    for (const TruePassage& passage : truth.passages) {
      if (passage.level == level) plan.Cross(passage.T_campus_robot.translation(), color);
    }
  }
  return plan.Png();
}

}  // namespace enfilade::simulator
