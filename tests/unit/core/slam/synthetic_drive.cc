// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/core/slam/synthetic_drive.h"

#include <cmath>
#include <cstring>
#include <limits>

namespace enfilade::testing {
namespace {

// SplitMix64 and Box-Muller: the same noise with every standard library.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15ULL + 1) {}
  double Uniform() {
    state_ += 0x9E3779B97F4A7C15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return (static_cast<double>((z ^ (z >> 31)) >> 11) + 0.5) / 9007199254740992.0;
  }
  double Gauss(double sigma) {
    const double radius = std::sqrt(-2.0 * std::log(Uniform()));
    return sigma * radius * std::cos(2.0 * M_PI * Uniform());
  }

 private:
  std::uint64_t state_;
};

double RangeTo(const Wall& wall, const Eigen::Vector2d& from, const Eigen::Vector2d& direction) {
  const Eigen::Vector2d along = wall.b - wall.a;
  const double determinant = direction.x() * along.y() - direction.y() * along.x();
  if (std::abs(determinant) < 1e-12) return std::numeric_limits<double>::infinity();
  const Eigen::Vector2d to = wall.a - from;
  const double range = (to.x() * along.y() - to.y() * along.x()) / determinant;
  const double share = (to.x() * direction.y() - to.y() * direction.x()) / determinant;
  return range > 0.0 && share >= 0.0 && share <= 1.0 ? range : std::numeric_limits<double>::infinity();
}

}  // namespace

sensor::LaserScan Scan(const std::vector<Wall>& walls, const Pose2& T_world_robot, const SyntheticScanner& scanner,
                       TimeNs time, std::uint64_t seed) {
  Noise noise(seed);
  sensor::LaserScan scan;
  scan.time = time;
  scan.angle_min = -scanner.field_of_view / 2.0;
  scan.angle_increment = scanner.field_of_view / scanner.beams;
  scan.range_max = static_cast<float>(scanner.range_max);
  for (int i = 0; i < scanner.beams; ++i) {
    const double angle = T_world_robot.yaw + scan.angle(static_cast<std::size_t>(i));
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    double range = std::numeric_limits<double>::infinity();
    for (const Wall& wall : walls) range = std::min(range, RangeTo(wall, T_world_robot.translation(), direction));
    scan.ranges.push_back(static_cast<float>(std::max(0.0, range + noise.Gauss(scanner.range_sigma))));
  }
  return scan;
}

std::vector<Pose2> Drive(const std::vector<Eigen::Vector2d>& corners, double step) {
  std::vector<Pose2> poses;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const Eigen::Vector2d along = corners[i + 1] - corners[i];
    const double yaw = std::atan2(along.y(), along.x());
    if (!poses.empty()) {
      const Pose2 before = poses.back();
      const double turn = WrapAngle(yaw - before.yaw);
      const int turns = static_cast<int>(std::ceil(std::abs(turn) / 0.2));
      for (int k = 1; k <= turns; ++k) {
        poses.push_back({corners[i].x(), corners[i].y(), WrapAngle(before.yaw + turn * k / turns)});
      }
    }
    const int steps = static_cast<int>(std::ceil(along.norm() / step));
    for (int k = poses.empty() ? 0 : 1; k <= steps; ++k) {
      const Eigen::Vector2d p = corners[i] + along * (static_cast<double>(k) / steps);
      poses.push_back({p.x(), p.y(), yaw});
    }
  }
  return poses;
}

std::vector<sensor::PairedScan> Record(const std::vector<Wall>& walls, const std::vector<Pose2>& poses,
                                       const SyntheticScanner& scanner, const SyntheticOdometry& odometry,
                                       std::uint64_t seed) {
  Noise noise(seed);
  std::vector<sensor::PairedScan> log;
  Pose2 T_odom_robot;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (i > 0) {
      Pose2 step = Between(poses[i - 1], poses[i]);
      const double length = step.translation().norm();
      step.x *= 1.0 + noise.Gauss(odometry.translation_share);
      step.yaw += noise.Gauss(odometry.yaw_per_metre * (length + 0.5 * std::abs(step.yaw)));
      T_odom_robot = T_odom_robot * step;
    }
    const auto time = static_cast<TimeNs>(i) * kNsPerSecond / 2 + 1'000'000'000LL * kNsPerSecond;
    log.push_back(
        {static_cast<std::int64_t>(i) + 1, Scan(walls, poses[i], scanner, time, seed + 7919 * (i + 1)), T_odom_robot});
  }
  return log;
}

std::vector<Wall> WallsFromText(const std::vector<const char*>& rows, double cell) {
  const auto filled = [&](int x, int y) {
    if (y < 0 || y >= static_cast<int>(rows.size())) return false;
    const char* row = rows[rows.size() - 1 - static_cast<std::size_t>(y)];
    return x >= 0 && x < static_cast<int>(std::strlen(row)) && row[x] == '#';
  };
  std::vector<Wall> walls;
  for (int y = 0; y < static_cast<int>(rows.size()); ++y) {
    for (int x = 0; x < 400; ++x) {
      if (!filled(x, y)) continue;
      const Eigen::Vector2d low(x * cell, y * cell);
      const Eigen::Vector2d high((x + 1) * cell, (y + 1) * cell);
      if (!filled(x, y - 1)) walls.push_back({low, {high.x(), low.y()}});
      if (!filled(x, y + 1)) walls.push_back({{low.x(), high.y()}, high});
      if (!filled(x - 1, y)) walls.push_back({low, {low.x(), high.y()}});
      if (!filled(x + 1, y)) walls.push_back({{high.x(), low.y()}, high});
    }
  }
  return walls;
}

}  // namespace enfilade::testing
