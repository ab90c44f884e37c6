// SPDX-License-Identifier: Apache-2.0
#include <png.h>

#include <algorithm>
#include <csetjmp>
#include <limits>

#include "client/simulator/sensors/sensors.h"
#include "core/base/error.h"
#include "core/grid/files/png_codec.h"

namespace enfilade::simulator {
namespace {

constexpr float kSky = 0.85F;
constexpr double kHorizon = 80.0;  // m, up to which surfaces are drawn

struct Column {
  double t;
  double u;  // the texture's coordinate
  double bottom;
  double top;
  Paint paint;
  float shade;
};

class Picture {
 public:
  Picture(const Viewpoint& view, const CameraOptions& options, Noise& noise)
      : view_(view),
        options_(options),
        noise_(noise),
        level_(view.world.level(view.level)),
        T_campus_camera_(view.T_campus_robot * options.T_robot_camera),
        focal_(options.focal_length()) {}

  CameraFrame Render() {
    CameraFrame frame;
    frame.width = options_.width;
    frame.height = options_.height;
    const auto pixels = static_cast<std::size_t>(options_.width) * static_cast<std::size_t>(options_.height);
    frame.grey.resize(pixels);
    frame.depth.resize(pixels);
    const auto exposure = static_cast<float>(1.0 + 0.05 * noise_.Normal());
    for (int x = 0; x < options_.width; ++x) {
      CastColumn(x);
      for (int y = 0; y < options_.height; ++y) {
        const auto pixel =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(options_.width) + static_cast<std::size_t>(x);
        const auto [brightness, depth] = ShadePixel(y);
        const double grey = 255.0 * static_cast<double>(brightness * exposure) + options_.noise * GaussianLike();
        frame.grey[pixel] = static_cast<std::uint8_t>(std::clamp(grey, 0.0, 255.0));
        frame.depth[pixel] = DepthOf(depth);
      }
    }
    return frame;
  }

 private:
  // Close enough to a normal distribution for pixel noise, and cheap: the sum of four uniform numbers.
  double GaussianLike() {
    const double sum = noise_.Uniform() + noise_.Uniform() + noise_.Uniform() + noise_.Uniform();
    return (sum - 2.0) * std::sqrt(3.0);
  }

  std::uint16_t DepthOf(double depth) {
    if (!(depth < options_.depth_max)) return 0;
    const double noisy = depth + options_.depth_sigma * depth * depth * GaussianLike();
    return static_cast<std::uint16_t>(std::clamp(1000.0 * noisy, 0.0, 65535.0));
  }

  void CastColumn(int x) {
    const double right = (x + 0.5 - options_.width / 2.0) / focal_;
    const double c = std::cos(T_campus_camera_.yaw);
    const double s = std::sin(T_campus_camera_.yaw);
    from_ = T_campus_camera_.translation();
    direction_ = {c + s * right, s - c * right};  // so that t is the depth along the optical axis
    columns_.clear();
    for (const World::PersonPosition& person : view_.world.PeopleOn(view_.level, view_.seconds)) {
      const double t = IntersectCircle(from_, direction_, person.at, person.radius);
      if (t == kNoHit) continue;
      const Eigen::Vector2d at = from_ + t * direction_ - person.at;
      columns_.push_back({t, person.radius * std::atan2(at.y(), at.x()), 0.0, person.height, {}, 0.5F});
    }
    level_.Traverse(from_, direction_, kHorizon, view_.gate, [&](double t, const Face& face) {
      if (face.glass) return true;
      const Eigen::Vector2d edge = face.b - face.a;
      const double along = (from_ + t * direction_ - face.a).dot(edge) / edge.squaredNorm();
      const double normal = std::abs(edge.x()) / edge.norm();
      columns_.push_back({t, face.u_a + along * (face.u_b - face.u_a), face.bottom, face.top, face.paint,
                          static_cast<float>(0.85 + 0.15 * normal)});
      return columns_.size() < 40;
    });
    std::stable_sort(columns_.begin(), columns_.end(), [](const Column& p, const Column& q) { return p.t < q.t; });
  }

  std::pair<float, double> ShadePixel(int y) const {
    const double slope = (options_.height / 2.0 - y - 0.5) / focal_;
    for (const Column& column : columns_) {
      const double z = options_.mount_height + column.t * slope;
      if (z < column.bottom || z >= column.top) {
        if (const auto seen = ShadeHorizontal(slope, column.t)) return *seen;
        continue;
      }
      if (const auto seen = ShadeHorizontal(slope, column.t)) return *seen;
      return {column.shade * BrightnessOf(column.paint, column.u, z, column.t / focal_), column.t};
    }
    if (const auto seen = ShadeHorizontal(slope, kHorizon)) return *seen;
    return {kSky, kNoHit};
  }

  // Floor or ceiling, if the ray hits it before `limit`.
  std::optional<std::pair<float, double>> ShadeHorizontal(double slope, double limit) const {
    if (slope < 0.0) {
      const double t = -options_.mount_height / slope;
      if (t >= limit) return std::nullopt;
      return ShadeFloorOrCeiling(t, slope, false);
    }
    const int here = level_.RasterAreaAt(from_.x(), from_.y());
    const double ceiling = here >= 0 ? view_.world.surfaces(here).ceiling_height : 3.0;
    const double t = slope > 0.0 ? (ceiling - options_.mount_height) / slope : kNoHit;
    if (t >= limit) return std::nullopt;
    const Eigen::Vector2d at = from_ + t * direction_;
    const int there = level_.RasterAreaAt(at.x(), at.y());
    if (there < 0 || !view_.world.surfaces(there).indoor) return std::nullopt;
    return ShadeFloorOrCeiling(t, slope, true);
  }
  std::pair<float, double> ShadeFloorOrCeiling(double t, double slope, bool ceiling) const {
    const Eigen::Vector2d at = from_ + t * direction_;
    const int area = level_.RasterAreaAt(at.x(), at.y());
    if (area < 0) return {0.4F, t};
    const AreaSurfaces& surfaces = view_.world.surfaces(area);
    const Paint& paint = ceiling ? surfaces.ceiling : surfaces.floor;
    double v = at.y();
    if (paint.period > 0.0F) v -= std::floor(v / paint.period) * paint.period;
    // Seen at an angle, a pixel covers more of the surface.
    const double footprint = t / focal_ / std::max(0.05, std::abs(slope));
    return {0.8F * BrightnessOf(paint, at.x(), v, footprint), t};
  }

  const Viewpoint& view_;
  const CameraOptions& options_;
  Noise& noise_;
  const LevelWorld& level_;
  Pose2 T_campus_camera_;
  double focal_;
  Eigen::Vector2d from_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d direction_ = Eigen::Vector2d::Zero();
  std::vector<Column> columns_;
};

void Append(png_structp png, png_bytep bytes, png_size_t size) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(bytes), size);
}
void Flush(png_structp) {}

// libpng reports errors by longjmp: nothing with a destructor may live in this frame.
bool WriteGrey16(png_structp png, png_infop header, const std::vector<std::uint16_t>& samples, int width, int height,
                 std::string& out) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_set_write_fn(png, &out, Append, Flush);
  png_set_compression_level(png, 3);
  png_set_IHDR(png, header, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), 16, PNG_COLOR_TYPE_GRAY,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, header);
  png_set_swap(png);  // PNG is big-endian
  for (int y = 0; y < height; ++y) {
    png_write_row(png, reinterpret_cast<png_const_bytep>(samples.data() + static_cast<std::ptrdiff_t>(y) * width));
  }
  png_write_end(png, header);
  return true;
}

}  // namespace

absl::Status CameraOptions::Validate() const {
  if (width < 8 || height < 8 || width > 8192 || height > 8192) {
    return InvalidArgument("a camera of {} x {} pixels: expected 8 to 8192", width, height);
  }
  if (!(field_of_view > 0.05 && field_of_view < 3.0)) {
    return InvalidArgument("a camera's field of view of {} rad: expected 0.05 to 3", field_of_view);
  }
  return absl::OkStatus();
}

CameraFrame ReadCamera(const Viewpoint& view, const CameraOptions& options, Noise noise) {
  return Picture(view, options, noise).Render();
}

absl::StatusOr<std::string> CameraFrame::GreyPng() const {
  return grid::EncodePng(grid::PixelRows{width, height, 1, grey.data(), width});
}

absl::StatusOr<std::string> CameraFrame::DepthPng() const {
  std::string out;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop header = png ? png_create_info_struct(png) : nullptr;
  const bool written = header && WriteGrey16(png, header, depth, width, height, out);
  png_destroy_write_struct(&png, &header);
  if (!written) return Internal("a depth image of {} x {} pixels cannot be written as PNG", width, height);
  return out;
}

}  // namespace enfilade::simulator
