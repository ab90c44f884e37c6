// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>
#include <string_view>

#include "core/base/status_macros.h"
#include "core/grid/files/png_codec.h"
#include "core/plot/scene.h"
#include "fmt/format.h"

namespace enfilade::plot {
namespace {

std::string Base64(std::string_view bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) bits = bits << 8U | (k < count ? static_cast<std::uint8_t>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kDigits[bits >> (18 - 6 * k) & 63U] : '=';
  }
  return text;
}

// Control characters, which XML 1.0 cannot represent, become spaces.
std::string Escape(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&') {
      escaped += "&amp;";
    } else if (c == '<') {
      escaped += "&lt;";
    } else if (c == '>') {
      escaped += "&gt;";
    } else {
      escaped += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return escaped;
}

std::string Hex(grid::Rgb color) { return fmt::format("#{:02x}{:02x}{:02x}", color[0], color[1], color[2]); }

absl::StatusOr<std::string> GridAsPng(const SceneRaster& raster) {
  const grid::GridGeometry& geometry = raster.grid.geometry;
  grid::PixelImage image{geometry.width, geometry.height, 4, {}};
  image.samples.reserve(4 * geometry.cell_count());
  for (int row = geometry.height - 1; row >= 0; --row) {
    for (int column = 0; column < geometry.width; ++column) {
      const std::uint8_t cell = raster.grid.cells[geometry.index(column, row)];
      const bool known = cell != grid::kUnknownCell;
      const grid::Rgb color = known ? ColorOfCell(cell, raster.color) : grid::Rgb{};
      image.samples.insert(image.samples.end(), color.begin(), color.end());
      image.samples.push_back(known ? 255 : 0);
    }
  }
  return grid::EncodePng(image);
}

absl::StatusOr<std::string> ToSvg(const SceneRaster& raster, const SceneView& view) {
  const grid::GridGeometry& geometry = raster.grid.geometry;
  const Pose2 T_scene_grid = raster.T_scene_map * geometry.T_map_grid;
  const Eigen::Vector2d corner =
      view.ToPixel(T_scene_grid * Eigen::Vector2d(0.0, geometry.height * geometry.resolution));
  const double scale = view.px_per_m * geometry.resolution;
  const double c = scale * std::cos(T_scene_grid.yaw);
  const double s = scale * std::sin(T_scene_grid.yaw);
  ENFILADE_ASSIGN_OR_RETURN(const std::string png, GridAsPng(raster));
  return fmt::format(
      "<image width=\"{}\" height=\"{}\" transform=\"matrix({:.6f} {:.6f} {:.6f} {:.6f} {:.3f} {:.3f})\" "
      "style=\"image-rendering:pixelated;mix-blend-mode:multiply\" xlink:href=\"data:image/png;base64,{}\"/>\n",
      geometry.width, geometry.height, c, -s, s, c, corner.x(), corner.y(), Base64(png));
}

std::string ToSvg(const SceneLine& line, const SceneView& view) {
  std::string points;
  for (const Eigen::Vector2d& p : line.points) {
    const Eigen::Vector2d pixel = view.ToPixel(p);
    points += fmt::format("{}{:.2f},{:.2f}", points.empty() ? "" : " ", pixel.x(), pixel.y());
  }
  return fmt::format("<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" points=\"{}\"/>\n", Hex(line.color),
                     line.width_px, points);
}

std::string ToSvg(const SceneEllipse& ellipse, const SceneView& view) {
  const Eigen::Vector2d at = view.ToPixel(ellipse.center);
  return fmt::format(
      "<ellipse rx=\"{:.3f}\" ry=\"{:.3f}\" transform=\"translate({:.2f} {:.2f}) rotate({:.4f})\" fill=\"none\" "
      "stroke=\"{}\" stroke-width=\"2\"/>\n",
      ellipse.semi_major_m * view.px_per_m, ellipse.semi_minor_m * view.px_per_m, at.x(), at.y(),
      -ellipse.angle * 180.0 / std::numbers::pi, Hex(ellipse.color));
}

std::string ToSvg(const SceneMarker& marker, const SceneView& view) {
  const Eigen::Vector2d at = view.ToPixel(marker.at);
  if (marker.shape == SceneMarker::Shape::kCross) {
    return fmt::format(
        "<path d=\"M-5 -5 L5 5 M-5 5 L5 -5\" transform=\"translate({:.2f} {:.2f})\" stroke=\"{}\" "
        "stroke-width=\"2\"/>\n",
        at.x(), at.y(), Hex(marker.color));
  }
  if (marker.shape == SceneMarker::Shape::kSquare) {
    return fmt::format("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"9\" height=\"9\" fill=\"{}\"/>\n", at.x() - 4.5,
                       at.y() - 4.5, Hex(marker.color));
  }
  const bool dot = marker.shape == SceneMarker::Shape::kDot;
  return fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"4\" stroke=\"{}\" stroke-width=\"2\" fill=\"{}\"/>\n",
                     at.x(), at.y(), Hex(marker.color), dot ? Hex(marker.color) : "white");
}

std::string ToSvg(const SceneLabel& label, const SceneView& view) {
  const Eigen::Vector2d at = view.ToPixel(label.at);
  return fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" fill=\"{}\">{}</text>\n", at.x() + 8, at.y() - 4,
                     Hex(label.color), Escape(label.text));
}

}  // namespace

absl::StatusOr<std::string> WriteSvg(const Scene& scene, const SceneView& view) {
  std::string svg = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" "
      "xmlns:xlink=\"http://www.w3.org/1999/xlink\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
      view.width, view.height);
  for (const SceneRaster& raster : scene.rasters) {
    ENFILADE_ASSIGN_OR_RETURN(const std::string image, ToSvg(raster, view));
    svg += image;
  }
  for (const SceneLine& line : scene.lines) svg += ToSvg(line, view);
  for (const SceneEllipse& ellipse : scene.ellipses) svg += ToSvg(ellipse, view);
  for (const SceneMarker& marker : scene.markers) svg += ToSvg(marker, view);
  for (const SceneLabel& label : scene.labels) svg += ToSvg(label, view);
  return svg + "</svg>\n";
}

}  // namespace enfilade::plot
