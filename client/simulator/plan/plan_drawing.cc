// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/plan/plan_drawing.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/base/error.h"
#include "core/grid/files/png_codec.h"

namespace enfilade::simulator {
namespace {

constexpr double kPaperBeyond = 30.0;    // px
constexpr double kPen = 2.0;             // px, of double lines
constexpr double kThinnest = 2.0;        // px, of filled walls
constexpr double kThinnestDouble = 8.0;  // px, of walls that are two lines
constexpr double kMostPixels = 64e6;

}  // namespace

double DistanceToInk(const Eigen::Vector2d& point, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                     double thickness) {
  const Eigen::Vector2d along = (to - from).normalized();
  const Eigen::Vector2d from_middle = point - (from + to) / 2;
  const double x = std::abs(from_middle.dot(along)) - (to - from).norm() / 2;
  const double y = std::abs(from_middle.x() * along.y() - from_middle.y() * along.x()) - thickness / 2;
  return std::hypot(std::max(x, 0.0), std::max(y, 0.0)) + std::min(std::max(x, y), 0.0);
}

absl::StatusOr<std::string> DrawSheet(const prior::PlanGraph& plan, LineStyle style) {
  Eigen::Vector2d high(0, 0);
  for (const prior::PlanCorner& corner : plan.corners) high = high.cwiseMax(corner.point);
  high.array() += kPaperBeyond + 1;
  if (high.x() * high.y() > kMostPixels) {
    return InvalidArgument("a plan of {:.0f} x {:.0f} pixels is too large to be drawn", high.x(), high.y());
  }
  grid::PixelImage image{
      .width = static_cast<int>(high.x()), .height = static_cast<int>(high.y()), .channels = 1, .samples = {}};
  const auto width = static_cast<std::size_t>(image.width);
  constexpr float kFar = 1e6F;
  std::vector<float> distance(width * static_cast<std::size_t>(image.height), kFar);
  for (const prior::PlanWall& wall : plan.walls) {
    const Eigen::Vector2d a = plan.corners[static_cast<std::size_t>(wall.from)].point;
    const Eigen::Vector2d b = plan.corners[static_cast<std::size_t>(wall.to)].point;
    const double thickness = std::max(style == LineStyle::kFilled ? kThinnest : kThinnestDouble, wall.thickness);
    // Corners are filled.
    const Eigen::Vector2d end = (b - a).normalized() * (thickness / 2);
    const double reach = thickness + kPen + 2;
    const int left = std::max(0, static_cast<int>(std::min(a.x(), b.x()) - reach));
    const int right = std::min(image.width - 1, static_cast<int>(std::max(a.x(), b.x()) + reach));
    const int top = std::max(0, static_cast<int>(std::min(a.y(), b.y()) - reach));
    const int bottom = std::min(image.height - 1, static_cast<int>(std::max(a.y(), b.y()) + reach));
    for (int y = top; y <= bottom; ++y) {
      for (int x = left; x <= right; ++x) {
        float& known = distance[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)];
        known = std::min(known, static_cast<float>(DistanceToInk({x, y}, a - end, b + end, thickness)));
      }
    }
  }
  image.samples.reserve(distance.size());
  for (const float to_edge : distance) {
    const double inside = style == LineStyle::kFilled ? -to_edge : kPen / 2 - std::abs(to_edge);
    image.samples.push_back(static_cast<std::uint8_t>(std::lround(255 * (1 - std::clamp(inside + 0.5, 0.0, 1.0)))));
  }
  return grid::EncodePng(image);
}

}  // namespace enfilade::simulator
