// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/prior/plan_overlay.h"

#include <algorithm>
#include <cmath>

namespace enfilade::cli {
namespace {

using Eigen::Vector2d;

constexpr grid::Rgb kWhite{255, 255, 255};
constexpr grid::Rgb kOrange{255, 127, 14};

// From units of the plan to pixels of the overlay.
struct OverlayFrame {
  Vector2d origin = Vector2d::Zero();
  double scale = 1;
  Vector2d ToPixel(const Vector2d& p) const { return scale * (p - origin); }
};

grid::RgbImage PalePicture(const perception::GreyFrame& picture, int enlarged) {
  grid::RgbImage image(picture.width * enlarged, picture.height * enlarged, kWhite);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const std::size_t from = static_cast<std::size_t>(y / enlarged) * picture.width + x / enlarged;
      const auto pale = static_cast<std::uint8_t>(150 + picture.pixels[from] * 105 / 255);
      std::fill_n(&image.samples[3 * (static_cast<std::size_t>(y) * image.width + x)], 3, pale);
    }
  }
  return image;
}

OverlayFrame FrameAround(const prior::PlanGraph& plan, double longer_side) {
  Vector2d low = plan.corners.front().point, high = low;
  for (const prior::PlanCorner& corner : plan.corners) {
    low = low.cwiseMin(corner.point);
    high = high.cwiseMax(corner.point);
  }
  const double size = std::max((high - low).maxCoeff(), 1e-9);
  OverlayFrame frame{.scale = 0.95 * longer_side / size};
  frame.origin = (low + high) / 2 - Vector2d::Constant(longer_side / frame.scale / 2);
  return frame;
}

void DrawOutline(grid::RgbImage& image, const OverlayFrame& frame, const std::vector<Vector2d>& outline,
                 grid::Rgb color) {
  for (std::size_t i = 0; i < outline.size(); ++i) {
    grid::DrawLine(image, frame.ToPixel(outline[i]), frame.ToPixel(outline[(i + 1) % outline.size()]), color, 2);
  }
}

grid::Rgb PalerBy(grid::Rgb color, double confidence) {
  for (std::uint8_t& sample : color)
    sample = static_cast<std::uint8_t>(255 - (255 - sample) * (0.4 + 0.6 * confidence));
  return color;
}

}  // namespace

grid::RgbImage DrawPlan(const prior::PlanGraph& plan, const std::optional<perception::GreyFrame>& picture) {
  constexpr int kSide = 1600;
  const int enlarged = picture ? std::max(1, kSide / std::max(picture->width, picture->height)) : 1;
  OverlayFrame frame;
  if (picture) {
    frame = {Vector2d::Constant(-(enlarged - 1.0) / (2.0 * enlarged)), static_cast<double>(enlarged)};
  } else if (!plan.corners.empty()) {
    frame = FrameAround(plan, kSide);
  }
  grid::RgbImage image = picture ? PalePicture(*picture, enlarged) : grid::RgbImage(kSide, kSide, kWhite);
  for (const prior::PlanShaft& shaft : plan.shafts) DrawOutline(image, frame, shaft.outline, kOrange);
  for (const prior::PlanWall& wall : plan.walls) {
    grid::DrawLine(image, frame.ToPixel(plan.corners[wall.from].point), frame.ToPixel(plan.corners[wall.to].point),
                   PalerBy(grid::kRed, wall.confidence), 2);
  }
  for (const prior::PlanDoor& door : plan.doors) {
    grid::DrawLine(image, frame.ToPixel(door.from), frame.ToPixel(door.to), grid::kBlue, 3);
  }
  for (const prior::PlanCorner& corner : plan.corners) {
    const Vector2d p = frame.ToPixel(corner.point);
    grid::DrawLine(image, p, p, grid::kGreen, 5);
  }
  return image;
}

}  // namespace enfilade::cli
