// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>

#include "client/simulator/sensors/sensors.h"
#include "core/base/error.h"

namespace enfilade::simulator {
namespace {

// Glass throws a beam back near its normal and lets it through elsewhere (Foster, Sun, Park, Kuipers 2013). `cosine`
// of the angle between the beam and the normal.
bool GlassAnswers(double cosine, Noise& noise) {
  constexpr double kSurely = 0.985;    // 10 deg
  constexpr double kNotAtAll = 0.906;  // 25 deg
  const double probability = std::clamp((cosine - kNotAtAll) / (kSurely - kNotAtAll), 0.0, 1.0);
  return probability > 0.0 && noise.Chance(0.95 * probability);
}

double CosineTo(const Face& face, const Eigen::Vector2d& direction) {
  const Eigen::Vector2d edge = (face.b - face.a).normalized();
  return std::abs(edge.x() * direction.y() - edge.y() * direction.x()) / direction.norm();
}

}  // namespace

absl::Status ScannerOptions::Validate() const {
  if (beams < 2 || beams > static_cast<int>(sensor::kMaxBeams))
    return InvalidArgument("beams is {}: expected 2 or more", beams);
  if (!(field_of_view > 0.0 && field_of_view <= 2.0 * M_PI + 1e-9)) {
    return InvalidArgument("field_of_view is {} rad: expected up to a full turn", field_of_view);
  }
  if (!(range_min >= 0.0 && range_max > range_min && range_max <= 1000.0)) {
    return InvalidArgument("ranges from {} to {} m are none", range_min, range_max);
  }
  if (!(range_sigma >= 0.0) || !(dropout >= 0.0 && dropout <= 1.0)) {
    return InvalidArgument("range_sigma {} m or dropout {} is none", range_sigma, dropout);
  }
  return absl::OkStatus();
}

sensor::LaserScan ReadScan(const Viewpoint& view, const ScannerOptions& options, Noise noise) {
  const LevelWorld& level = view.world.level(view.level);
  const std::vector<World::Standing> people = view.world.PeopleOn(view.level, view.seconds);
  sensor::LaserScan scan;
  const bool full_turn = options.field_of_view > 2.0 * M_PI - 1e-6;
  scan.angle_min = -options.field_of_view / 2.0;
  scan.angle_increment = options.field_of_view / (full_turn ? options.beams : options.beams - 1);
  scan.range_min = static_cast<float>(options.range_min);
  scan.range_max = static_cast<float>(options.range_max);
  scan.T_robot_laser = options.T_robot_laser;
  const Pose2 T_campus_laser = view.T_campus_robot * options.T_robot_laser;
  const Eigen::Vector2d from = T_campus_laser.translation();
  scan.ranges.reserve(static_cast<std::size_t>(options.beams));
  for (int i = 0; i < options.beams; ++i) {
    const double bearing = T_campus_laser.yaw + scan.angle(static_cast<std::size_t>(i));
    const Eigen::Vector2d direction(std::cos(bearing), std::sin(bearing));
    double nearest = kNever;
    for (const World::Standing& person : people) {
      if (person.height > options.height)
        nearest = std::min(nearest, MeetCircle(from, direction, person.at, person.radius));
    }
    level.Traverse(from, direction, std::min(nearest, options.range_max), view.gate, [&](double t, const Face& face) {
      if (options.height < face.bottom || options.height >= face.top) return true;
      if (face.glass && !GlassAnswers(CosineTo(face, direction), noise)) return true;
      nearest = t;
      return false;
    });
    const double error = options.range_sigma * noise.Normal();
    float range = std::numeric_limits<float>::infinity();
    if (nearest < options.range_max) range = static_cast<float>(std::max(0.0, nearest + error));
    if (noise.Chance(options.dropout)) range = std::numeric_limits<float>::quiet_NaN();
    scan.ranges.push_back(range);
  }
  return scan;
}

std::vector<float> ReadCloud(const Viewpoint& view, const CloudScannerOptions& options, Noise noise) {
  const LevelWorld& level = view.world.level(view.level);
  const std::vector<World::Standing> people = view.world.PeopleOn(view.level, view.seconds);
  const Pose2 T_campus_scanner = view.T_campus_robot * options.T_robot_scanner;
  const Eigen::Vector2d from = T_campus_scanner.translation();
  const auto rings = static_cast<std::size_t>(options.rings);
  std::vector<double> tangents(rings);
  for (std::size_t r = 0; r < rings; ++r)
    tangents[r] = std::tan(options.lowest + options.step * static_cast<double>(r));
  std::vector<float> cloud;
  for (int i = 0; i < options.azimuths; ++i) {
    const double angle = 2.0 * M_PI * i / options.azimuths;
    const double bearing = T_campus_scanner.yaw + angle;
    const Eigen::Vector2d direction(std::cos(bearing), std::sin(bearing));
    std::vector<double> reach(rings, kNever);  // horizontal distance of each ring's return
    for (std::size_t r = 0; r < rings; ++r) {
      const double tangent = tangents[r];
      if (tangent < 0.0) reach[r] = -options.height / tangent;  // the floor
      for (const World::Standing& person : people) {
        const double t = MeetCircle(from, direction, person.at, person.radius);
        const double z = options.height + t * tangent;
        if (t < reach[r] && z >= 0.0 && z < person.height) reach[r] = t;
      }
      if (tangent <= 0.0) continue;
      // The ceiling, where there is one above.
      const int here = level.RasterAreaAt(from.x(), from.y());
      if (here < 0 || !view.world.look(here).indoor) continue;
      const double t = (view.world.look(here).ceiling - options.height) / tangent;
      const int there = level.RasterAreaAt(from.x() + t * direction.x(), from.y() + t * direction.y());
      if (there >= 0 && view.world.look(there).indoor) reach[r] = std::min(reach[r], t);
    }
    std::size_t open = rings;
    std::vector<bool> met(rings, false);
    level.Traverse(from, direction, options.range_max, view.gate, [&](double t, const Face& face) {
      const bool answers = !face.glass || GlassAnswers(CosineTo(face, direction), noise);
      for (std::size_t r = 0; answers && r < rings; ++r) {
        const double z = options.height + t * tangents[r];
        if (met[r]) continue;
        if (reach[r] <= t) {
          met[r] = true;
          --open;
        } else if (z >= face.bottom && z < face.top) {
          reach[r] = t;
          met[r] = true;
          --open;
        }
      }
      return open > 0;
    });
    for (std::size_t r = 0; r < rings; ++r) {
      const double slant = std::sqrt(1.0 + tangents[r] * tangents[r]);
      const double error = options.range_sigma * noise.Normal();
      const bool missing = noise.Chance(options.dropout);
      if (missing || !(reach[r] * slant < options.range_max)) continue;
      const double t = std::max(0.0, reach[r] + error / slant);
      const Eigen::Vector2d point = options.T_robot_scanner * Eigen::Vector2d(t * std::cos(angle), t * std::sin(angle));
      cloud.push_back(static_cast<float>(point.x()));
      cloud.push_back(static_cast<float>(point.y()));
      cloud.push_back(static_cast<float>(options.height + t * tangents[r]));
    }
  }
  return cloud;
}

}  // namespace enfilade::simulator
