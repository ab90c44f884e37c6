// SPDX-License-Identifier: Apache-2.0
#include "tests/support/plans/photo.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>

#include "core/grid/files/png_codec.h"

namespace enfilade::testing {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kRadian = M_PI / 180;

// Of a plane through the point that the camera looks at, `distance` in front of it.
Matrix3d HomographyOf(const PhotoOptions& options, const Vector2d& middle, double focal, double distance) {
  const Matrix3d R = (Eigen::AngleAxisd(options.roll_deg * kRadian, Vector3d::UnitZ()) *
                      Eigen::AngleAxisd(options.tilt_deg * kRadian, Vector3d::UnitX()) *
                      Eigen::AngleAxisd(options.pan_deg * kRadian, Vector3d::UnitY()))
                         .toRotationMatrix();
  Matrix3d camera = Matrix3d::Identity(), plane, centre = Matrix3d::Identity();
  camera(0, 0) = camera(1, 1) = focal;
  plane << R.col(0), R.col(1), Vector3d(0, 0, distance);
  centre.topRightCorner<2, 1>() = -middle;
  return camera * plane * centre;
}

double BrightnessAt(const grid::PixelImage& image, const Vector2d& p) {
  const int x = std::clamp(static_cast<int>(std::floor(p.x())), 0, image.width - 2);
  const int y = std::clamp(static_cast<int>(std::floor(p.y())), 0, image.height - 2);
  const double u = std::clamp(p.x() - x, 0.0, 1.0), v = std::clamp(p.y() - y, 0.0, 1.0);
  const auto at = [&](int column, int row) {
    return static_cast<double>(image.samples[static_cast<std::size_t>(row) * image.width + column]);
  };
  return (1 - v) * ((1 - u) * at(x, y) + u * at(x + 1, y)) + v * ((1 - u) * at(x, y + 1) + u * at(x + 1, y + 1));
}

}  // namespace

Photo TakePhoto(const std::string& sheet, const PhotoOptions& options) {
  const grid::PixelImage paper = grid::DecodePng(sheet).value();
  const Vector2d size(paper.width, paper.height);
  const Vector2d middle = (size - Vector2d::Ones()) / 2;
  grid::PixelImage image{.width = 4 * paper.width / 3, .height = 4 * paper.height / 3, .channels = 1, .samples = {}};
  const Vector2d picture(image.width, image.height);
  const double focal = options.focal * picture.norm();
  double distance = focal;
  Matrix3d H = HomographyOf(options, middle, focal, distance);
  // As near as the paper fits into the photo.
  for (int i = 0; i < 20; ++i) {
    double widest = 0;
    for (const Vector2d& corner : {Vector2d(0, 0), Vector2d(size.x(), 0), size, Vector2d(0, size.y())}) {
      const Vector2d seen = (H * corner.homogeneous()).eval().hnormalized();
      widest = std::max(widest, (2 * seen.cwiseAbs().cwiseQuotient(picture)).maxCoeff());
    }
    distance *= widest / options.fill;
    H = HomographyOf(options, middle, focal, distance);
  }
  Matrix3d shift = Matrix3d::Identity();
  shift.topRightCorner<2, 1>() = (picture - Vector2d::Ones()) / 2;
  Photo photo{.png = {}, .H_photo_sheet = shift * H};
  const Matrix3d H_sheet_photo = photo.H_photo_sheet.inverse();
  std::mt19937 random(options.seed);
  std::normal_distribution<double> noise(0, options.noise);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Vector2d p = (H_sheet_photo * Vector3d(x, y, 1)).eval().hnormalized();
      const bool on_paper = (p.array() >= -0.5).all() && (p.array() <= size.array() - 0.5).all();
      const double grain = 20 * std::sin(0.11 * y + 2 * std::sin(0.013 * x)) + 8 * std::sin(0.7 * y + 0.02 * x);
      const double surface = on_paper ? BrightnessAt(paper, p) : 255 * options.table + grain;
      const double light = 1 + (options.shade_at_edge - 1) * x / image.width;
      image.samples.push_back(
          static_cast<std::uint8_t>(std::lround(std::clamp(light * surface + noise(random), 0.0, 255.0))));
    }
  }
  photo.png = grid::EncodePng(image).value();
  return photo;
}

}  // namespace enfilade::testing
