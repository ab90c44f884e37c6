// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/offline/doors_plot.h"

#include <algorithm>
#include <cmath>

#include "core/doors/jamb_derivative.h"
#include "core/grid/files/rgb_image.h"

namespace enfilade::cli {
namespace {

constexpr int kWidth = 1400;
constexpr int kStrip = 361;  // pixels: one per degree
constexpr int kGap = 12;
constexpr grid::Rgb kOrange{240, 150, 30};
constexpr grid::Rgb kGrey{150, 150, 150};

class DoorPlot {
 public:
  DoorPlot(const std::vector<sensor::PairedScan>& scans, const std::vector<doors::DoorEvent>& events)
      : scans_(scans), events_(events), image_(1, 1, {}) {
    Eigen::Vector2d low(0.0, 0.0);
    Eigen::Vector2d high(1.0, 1.0);
    bool first = true;
    for (const sensor::PairedScan& scan : scans_) {
      const Eigen::Vector2d at = scan.T_odom_robot->translation();
      low = first ? at : Eigen::Vector2d(low.cwiseMin(at));
      high = first ? at : Eigen::Vector2d(high.cwiseMax(at));
      first = false;
    }
    low_ = low - Eigen::Vector2d(5.0, 5.0);
    high_ = high + Eigen::Vector2d(5.0, 5.0);
    scale_ = std::min(kWidth / (high_ - low_).x(), 1200.0 / (high_ - low_).y());
    image_ = grid::RgbImage(kWidth, kStrip + kGap + static_cast<int>(scale_ * (high_ - low_).y()), {255, 255, 255});
  }

  absl::StatusOr<std::string> Draw(const doors::DerivativeOptions& options) {
    DrawDerivative(options);
    DrawPath();
    return grid::EncodePng(image_);
  }

 private:
  void Set(int x, int y, grid::Rgb color) {
    if (x < 0 || y < 0 || x >= image_.width || y >= image_.height) return;
    std::copy(color.begin(), color.end(),
              image_.samples.begin() + 3 * (static_cast<std::ptrdiff_t>(y) * image_.width + x));
  }
  int ColumnOf(TimeNs time) const {
    const auto begin = static_cast<double>(scans_.front().scan.time);
    const double span = std::max(1.0, static_cast<double>(scans_.back().scan.time) - begin);
    return static_cast<int>((static_cast<double>(time) - begin) / span * (kWidth - 1));
  }
  Eigen::Vector2d PixelOfPoint(const Eigen::Vector2d& p) const {
    return {(p.x() - low_.x()) * scale_, kStrip + kGap + (high_.y() - p.y()) * scale_};
  }

  void DrawDerivative(const doors::DerivativeOptions& options) {
    for (std::size_t s = 0; s < scans_.size(); ++s) {
      const sensor::LaserScan& scan = scans_[s].scan;
      const std::vector<double> derivative = doors::ScanDerivative(scan, options);
      const int begin = ColumnOf(scan.time);
      const int end = s + 1 < scans_.size() ? std::min(begin + 30, ColumnOf(scans_[s + 1].scan.time)) : begin + 1;
      for (std::size_t i = 0; i < derivative.size(); ++i) {
        if (std::isnan(derivative[i])) continue;
        const double bearing = WrapAngle(scan.angle(i) + scan.T_robot_laser.yaw) * 180.0 / M_PI;
        const double strength = std::clamp(derivative[i] / (2.0 * options.threshold), -1.0, 1.0);
        const auto pale = static_cast<std::uint8_t>(255.0 * (1.0 - std::abs(strength)));
        if (pale > 245) continue;
        const grid::Rgb color = strength > 0.0 ? grid::Rgb{255, pale, pale} : grid::Rgb{pale, pale, 255};
        for (int x = begin; x < std::max(end, begin + 1); ++x)
          Set(x, 180 - static_cast<int>(std::lround(bearing)), color);
      }
    }
    for (const doors::DoorEvent& event : events_) {
      const grid::Rgb color = event.kind == doors::DoorEvent::Kind::kPassage   ? grid::kGreen
                              : event.kind == doors::DoorEvent::Kind::kLatched ? kOrange
                                                                               : kGrey;
      const int x = ColumnOf(event.kind == doors::DoorEvent::Kind::kPassage ? event.door_time : event.time);
      grid::DrawLine(image_, Eigen::Vector2d(x, 0), Eigen::Vector2d(x, kStrip - 1), color, 1);
    }
  }

  void DrawPath() {
    for (const sensor::PairedScan& scan : scans_) {
      for (const Eigen::Vector2d& p : sensor::HitPoints(scan.scan, 5.0)) {
        const Eigen::Vector2d pixel = PixelOfPoint(*scan.T_odom_robot * p);
        if (pixel.y() > kStrip) Set(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()), {190, 190, 190});
      }
    }
    for (std::size_t s = 1; s < scans_.size(); ++s) {
      grid::DrawLine(image_, PixelOfPoint(scans_[s - 1].T_odom_robot->translation()),
                     PixelOfPoint(scans_[s].T_odom_robot->translation()), grid::kBlue, 1);
    }
    for (const doors::DoorEvent& event : events_) {
      const Eigen::Vector2d at = event.T_odom_door.translation();
      const Eigen::Vector2d across(-std::sin(event.T_odom_door.yaw), std::cos(event.T_odom_door.yaw));
      if (event.kind == doors::DoorEvent::Kind::kPassage) {
        const double half = std::max(0.4, event.width / 2.0);
        grid::DrawLine(image_, PixelOfPoint(at - half * across), PixelOfPoint(at + half * across), grid::kGreen, 3);
      } else if (event.kind == doors::DoorEvent::Kind::kCandidate) {
        const Eigen::Vector2d arm(0.2, 0.2);
        const Eigen::Vector2d other(-0.2, 0.2);
        grid::DrawLine(image_, PixelOfPoint(at - arm), PixelOfPoint(at + arm), kOrange, 2);
        grid::DrawLine(image_, PixelOfPoint(at - other), PixelOfPoint(at + other), kOrange, 2);
      }
    }
  }

  const std::vector<sensor::PairedScan>& scans_;
  const std::vector<doors::DoorEvent>& events_;
  Eigen::Vector2d low_;
  Eigen::Vector2d high_;
  double scale_ = 1.0;  // pixels per metre
  grid::RgbImage image_;
};

}  // namespace

absl::StatusOr<std::string> DrawDoors(const std::vector<sensor::PairedScan>& scans,
                                      const std::vector<doors::DoorEvent>& events,
                                      const doors::DerivativeOptions& options) {
  return DoorPlot(scans, events).Draw(options);
}

}  // namespace enfilade::cli
