// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>

#include "client/simulator/sensors/sensors.h"
#include "core/base/error.h"

namespace enfilade::simulator {
namespace {

// Glass reflects a beam near its normal and lets it through otherwise (Foster, Sun, Park, Kuipers 2013). `cosine`: of
// the angle between the beam and the normal.
bool GlassReflects(double cosine, Noise& noise) {
  constexpr double kAlways = 0.985;  // 10 deg
  constexpr double kNever = 0.906;   // 25 deg
  const double probability = std::clamp((cosine - kNever) / (kAlways - kNever), 0.0, 1.0);
  return probability > 0.0 && noise.Chance(0.95 * probability);
}

double CosineTo(const Face& face, const Eigen::Vector2d& direction) {
  const Eigen::Vector2d edge = (face.b - face.a).normalized();
  return std::abs(edge.x() * direction.y() - edge.y() * direction.x()) / direction.norm();
}

// One turn of a scanner with several rings. Each ring's reach is the horizontal distance of its return.
class CloudReader {
 public:
  CloudReader(const Viewpoint& view, const CloudScannerOptions& options, Noise& noise)
      : view_(view),
        options_(options),
        noise_(noise),
        level_(view.world.level(view.level)),
        people_(view.world.PeopleOn(view.level, view.seconds)),
        T_campus_scanner_(view.T_campus_robot * options.T_robot_scanner),
        from_(T_campus_scanner_.translation()),
        rings_(static_cast<std::size_t>(options.rings)),
        tangents_(rings_) {
    for (std::size_t r = 0; r < rings_; ++r) {
      tangents_[r] = std::tan(options.lowest + options.step * static_cast<double>(r));
    }
  }

  // Appends the returns of all rings at `angle` in the scanner's frame.
  void ReadAzimuth(double angle, std::vector<float>& cloud) {
    const double bearing = T_campus_scanner_.yaw + angle;
    const Eigen::Vector2d direction(std::cos(bearing), std::sin(bearing));
    std::vector<double> reach(rings_);
    for (std::size_t r = 0; r < rings_; ++r) reach[r] = ReachWithoutFaces(direction, tangents_[r]);
    HitFaces(direction, reach);
    for (std::size_t r = 0; r < rings_; ++r) {
      const double slant = std::sqrt(1.0 + tangents_[r] * tangents_[r]);
      const double error = options_.range_sigma * noise_.Normal();
      const bool missing = noise_.Chance(options_.dropout);
      if (missing || !(reach[r] * slant < options_.range_max)) continue;
      const double t = std::max(0.0, reach[r] + error / slant);
      const Eigen::Vector2d point =
          options_.T_robot_scanner * Eigen::Vector2d(t * std::cos(angle), t * std::sin(angle));
      cloud.push_back(static_cast<float>(point.x()));
      cloud.push_back(static_cast<float>(point.y()));
      cloud.push_back(static_cast<float>(options_.height + t * tangents_[r]));
    }
  }

 private:
  // Up to the floor, a person or the ceiling.
  double ReachWithoutFaces(const Eigen::Vector2d& direction, double tangent) const {
    double reach = kNoHit;
    if (tangent < 0.0) reach = -options_.height / tangent;
    for (const World::PersonPosition& person : people_) {
      const double t = IntersectCircle(from_, direction, person.at, person.radius);
      const double z = options_.height + t * tangent;
      if (t < reach && z >= 0.0 && z < person.height) reach = t;
    }
    if (tangent <= 0.0) return reach;
    const int here = level_.RasterAreaAt(from_.x(), from_.y());
    if (here < 0 || !view_.world.surfaces(here).indoor) return reach;
    const double t = (view_.world.surfaces(here).ceiling_height - options_.height) / tangent;
    const int there = level_.RasterAreaAt(from_.x() + t * direction.x(), from_.y() + t * direction.y());
    if (there >= 0 && view_.world.surfaces(there).indoor) reach = std::min(reach, t);
    return reach;
  }

  // Shortens each ring's reach to the first face that it hits.
  void HitFaces(const Eigen::Vector2d& direction, std::vector<double>& reach) {
    std::size_t open = rings_;
    std::vector<bool> done(rings_, false);
    level_.Traverse(from_, direction, options_.range_max, view_.gate, [&](double t, const Face& face) {
      const bool reflects = !face.glass || GlassReflects(CosineTo(face, direction), noise_);
      for (std::size_t r = 0; reflects && r < rings_; ++r) {
        if (done[r]) continue;
        const double z = options_.height + t * tangents_[r];
        const bool hit = reach[r] > t && z >= face.bottom && z < face.top;
        if (hit) reach[r] = t;
        if (!hit && reach[r] > t) continue;
        done[r] = true;
        --open;
      }
      return open > 0;
    });
  }

  const Viewpoint& view_;
  const CloudScannerOptions& options_;
  Noise& noise_;
  const LevelWorld& level_;
  const std::vector<World::PersonPosition> people_;
  const Pose2 T_campus_scanner_;
  const Eigen::Vector2d from_;
  const std::size_t rings_;
  std::vector<double> tangents_;
};

}  // namespace

absl::Status ScannerOptions::Validate() const {
  if (beams < 2 || beams > static_cast<int>(sensor::kMaxBeams))
    return InvalidArgument("beams is {}: expected 2 to {}", beams, sensor::kMaxBeams);
  if (!(field_of_view > 0.0 && field_of_view <= 2.0 * M_PI + 1e-9)) {
    return InvalidArgument("field_of_view is {} rad: expected up to a full turn", field_of_view);
  }
  if (!(range_min >= 0.0 && range_max > range_min && range_max <= 1000.0)) {
    return InvalidArgument("range_min is {} m and range_max {} m: expected 0 to 1000 and range_min below range_max",
                           range_min, range_max);
  }
  if (!(range_sigma >= 0.0) || !(dropout >= 0.0 && dropout <= 1.0)) {
    return InvalidArgument("range_sigma is {} m and dropout {}: expected 0 or more, and 0 to 1", range_sigma, dropout);
  }
  return absl::OkStatus();
}

sensor::LaserScan ReadScan(const Viewpoint& view, const ScannerOptions& options, Noise noise) {
  const LevelWorld& level = view.world.level(view.level);
  const std::vector<World::PersonPosition> people = view.world.PeopleOn(view.level, view.seconds);
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
    double nearest = kNoHit;
    for (const World::PersonPosition& person : people) {
      if (person.height > options.height)
        nearest = std::min(nearest, IntersectCircle(from, direction, person.at, person.radius));
    }
    level.Traverse(from, direction, std::min(nearest, options.range_max), view.gate, [&](double t, const Face& face) {
      if (options.height < face.bottom || options.height >= face.top) return true;
      if (face.glass && !GlassReflects(CosineTo(face, direction), noise)) return true;
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
  CloudReader reader(view, options, noise);
  std::vector<float> cloud;
  for (int i = 0; i < options.azimuths; ++i) reader.ReadAzimuth(2.0 * M_PI * i / options.azimuths, cloud);
  return cloud;
}

}  // namespace enfilade::simulator
