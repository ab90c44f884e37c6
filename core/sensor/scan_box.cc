// SPDX-License-Identifier: Apache-2.0
#include "core/sensor/scan_box.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace enfilade::sensor {
namespace {

bool IsFullTurn(const LaserScan& scan) {
  const double span = std::abs(scan.angle_increment) * static_cast<double>(scan.ranges.size());
  return span > 2.0 * M_PI - 1.5 * std::abs(scan.angle_increment);
}

// Sums over the first k beams, so the mean of any window takes two look-ups.
struct Sums {
  std::vector<double> ranges{0.0};
  std::vector<int> hits{0};
};

Sums SumsOf(const LaserScan& scan) {
  Sums sums;
  for (const float range : scan.ranges) {
    const bool is_hit = ClassifyBeam(scan, range) == BeamKind::kHit && range > 0.0F;
    sums.ranges.push_back(sums.ranges.back() + (is_hit ? static_cast<double>(range) : 0.0));
    sums.hits.push_back(sums.hits.back() + (is_hit ? 1 : 0));
  }
  return sums;
}

}  // namespace

std::vector<std::optional<double>> MeanFilteredRanges(const LaserScan& scan, int half_width) {
  const auto n = static_cast<std::ptrdiff_t>(scan.ranges.size());
  const std::ptrdiff_t width = std::max(half_width, 0);
  const Sums sums = SumsOf(scan);
  const bool wraps = IsFullTurn(scan);
  std::vector<std::optional<double>> means(scan.ranges.size());
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    double sum = 0.0;
    int hits = 0;
    const auto add = [&](std::ptrdiff_t first, std::ptrdiff_t end) {  // beams [first, end)
      const auto from = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(first, 0, n));
      const auto to = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(end, 0, n));
      if (from >= to) return;
      sum += sums.ranges[to] - sums.ranges[from];
      hits += sums.hits[to] - sums.hits[from];
    };
    if (2 * width + 1 >= n && wraps) {
      add(0, n);  // every beam once
    } else {
      add(i - width, i + width + 1);
      if (wraps && i - width < 0) add(n + i - width, n);
      if (wraps && i + width + 1 > n) add(0, i + width + 1 - n);
    }
    if (hits > 0) means[static_cast<std::size_t>(i)] = sum / hits;
  }
  return means;
}

Eigen::AlignedBox2d FilteredBox(const LaserScan& scan, int half_width, const Pose2& T_frame_robot) {
  const Pose2 T_frame_laser = T_frame_robot * scan.T_robot_laser;
  const std::vector<std::optional<double>> means = MeanFilteredRanges(scan, half_width);
  Eigen::AlignedBox2d box;
  for (std::size_t i = 0; i < means.size(); ++i) {
    if (!means[i]) continue;
    const double angle = scan.angle(i);
    box.extend(T_frame_laser * Eigen::Vector2d(*means[i] * std::cos(angle), *means[i] * std::sin(angle)));
  }
  return box;
}

}  // namespace enfilade::sensor
