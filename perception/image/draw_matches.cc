// SPDX-License-Identifier: Apache-2.0
#include "perception/image/draw_matches.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/base/status_macros.h"

namespace enfilade::perception {
namespace {

constexpr int kWidth = 1280;
constexpr int kGap = 8;

// Draws `frame`, scaled down by the factor `step` (nearest pixel), with its left edge at `left`.
void Paste(const GreyFrame& frame, double step, int left, grid::RgbImage& picture) {
  const int width = static_cast<int>(frame.width / step);
  const int height = static_cast<int>(frame.height / step);
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const auto source_row =
          std::min(static_cast<std::size_t>(row * step), static_cast<std::size_t>(frame.height - 1));
      const auto source_column =
          std::min(static_cast<std::size_t>(column * step), static_cast<std::size_t>(frame.width - 1));
      const std::uint8_t grey = frame.pixels[source_row * static_cast<std::size_t>(frame.width) + source_column];
      const std::size_t sample = 3 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(picture.width) +
                                      static_cast<std::size_t>(left + column));
      std::fill_n(picture.samples.begin() + static_cast<std::ptrdiff_t>(sample), 3, grey);
    }
  }
}

}  // namespace

absl::StatusOr<grid::RgbImage> DrawMatches(const GreyFrame& a, const GreyFrame& b, const ImageMatch& match) {
  ENFILADE_RETURN_IF_ERROR(Validate(a));
  ENFILADE_RETURN_IF_ERROR(Validate(b));
  const double half = (kWidth - kGap) / 2.0;
  const double step_a = std::max({1.0, a.width / half, a.height / half});
  const double step_b = std::max({1.0, b.width / half, b.height / half});
  const int left_b = std::max(1, static_cast<int>(a.width / step_a)) + kGap;
  const int width = left_b + std::max(1, static_cast<int>(b.width / step_b));
  const int height = std::max({1, static_cast<int>(a.height / step_a), static_cast<int>(b.height / step_b)});
  grid::RgbImage picture(width, height, {24, 24, 24});
  Paste(a, step_a, 0, picture);
  Paste(b, step_b, left_b, picture);
  for (const bool inliers : {false, true}) {
    for (const PointPair& pair : match.pairs) {
      if (pair.is_inlier != inliers) continue;
      const Eigen::Vector2d from = pair.a.cast<double>() / step_a;
      const Eigen::Vector2d to = pair.b.cast<double>() / step_b + Eigen::Vector2d(left_b, 0.0);
      grid::DrawLine(picture, from, to, inliers ? grid::kGreen : grid::kRed);
      if (!inliers) continue;
      for (const Eigen::Vector2d& end : {from, to}) grid::DrawLine(picture, end, end, grid::kBlue, 5);
    }
  }
  return picture;
}

}  // namespace enfilade::perception
