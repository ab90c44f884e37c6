// SPDX-License-Identifier: Apache-2.0
#include "tests/support/corridor.h"

#include <cmath>
#include <string>
#include <utility>

#include "client/simulator/sensors/sensors.h"
#include "core/base/noise.h"

namespace enfilade::testing {
namespace {

using simulator::Campus;

constexpr double kHeight = 2.8;  // m, of the ceiling

// A flat box on a wall, from x to x + width.
void Hang(double x, double width, double y, double thickness, double bottom, double top, const std::string& texture,
          Campus& campus) {
  campus.boxes.push_back(
      {"0", simulator::RectangleOutline(x, y - thickness / 2.0, width, thickness), bottom, top, texture});
}

// The doors and posters of the wall at y, whose inner side is towards `inside` (+1 or -1).
void FurnishWall(double length, double y, double inside, Noise& noise, Campus& campus) {
  const double at = y + inside * 0.09;
  const double spacing = noise.Uniform(2.4, 5.0);
  const double posters = noise.Uniform(0.15, 0.7);  // share of the places between doors
  for (double x = noise.Uniform(0.3, spacing); x + 1.0 < length; x += spacing + noise.Uniform(-0.3, 0.3)) {
    Hang(x, 0.95, at, 0.06, 0.0, 2.05, "door", campus);
    Hang(x + 0.3, 0.25, at + inside * 0.02, 0.06, 1.45, 1.6, "plate", campus);
    for (double p = x + 1.1; p + 0.7 < x + spacing - 0.1; p += 0.9) {
      if (noise.Uniform() < posters)
        Hang(p, noise.Uniform(0.3, 0.7), at, 0.04, noise.Uniform(0.9, 1.3), 1.9, "poster", campus);
    }
  }
}

CorridorPair SeeTwice(const Corridor& corridor, double along, std::uint64_t seed) {
  Noise noise(seed);
  const double x = noise.Uniform(0.5, std::max(1.0, corridor.length() - 7.0 - along));
  const Pose2 first{x, corridor.middle() + noise.Uniform(-0.2, 0.2), noise.Uniform(-0.1, 0.1)};
  const Pose2 second{x + along, corridor.middle() + noise.Uniform(-0.3, 0.3), first.yaw + noise.Uniform(-0.15, 0.15)};
  return {corridor.See(first, 2 * seed), corridor.See(second, 2 * seed + 1)};
}

}  // namespace

Corridor::Corridor(std::uint64_t seed)
    : seed_(seed),
      length_(Noise(seed).Uniform(14.0, 40.0)),
      width_(Noise(seed + 1).Uniform(1.7, 3.0)),
      world_(Draw(seed, length_, width_)) {}

Campus Corridor::Draw(std::uint64_t seed, double length, double width) {
  Noise noise(seed + 2);
  Campus campus;
  campus.name = "corridor";
  campus.texture_seed = seed;
  campus.levels["0"] = 0.0;
  campus.textures["wall"] = {.contrast = noise.Uniform(0.05, 0.35), .brightness = 0.65};
  campus.textures["door"] = {.contrast = noise.Uniform(0.05, 0.25), .brightness = 0.35};
  campus.textures["plate"] = {.contrast = 1.0, .brightness = 0.7};
  campus.textures["poster"] = {.contrast = 1.2, .brightness = 0.6};
  campus.textures["end"] = {.contrast = noise.Uniform(0.6, 1.2), .brightness = 0.6};
  simulator::Area area;
  area.id = "corridor";
  area.kind = simulator::AreaKind::kCorridor;
  area.level = "0";
  area.outline = simulator::RectangleOutline(0.0, 0.0, length, width);
  area.wall_height = kHeight;
  area.texture = "wall";
  campus.areas.push_back(area);
  FurnishWall(length, 0.0, 1.0, noise, campus);
  FurnishWall(length, width, -1.0, noise, campus);
  campus.boxes.push_back(
      {"0", simulator::RectangleOutline(length - 0.15, 0.08, 0.1, width - 0.16), 0.0, kHeight, "end"});
  return campus;
}

perception::FeatureSet Corridor::See(const Pose2& T_corridor_robot, std::uint64_t take) const {
  const simulator::CameraFrame seen =
      simulator::ReadCamera({world_, "0", T_corridor_robot}, {}, Noise(Mix(seed_, take)));
  return perception::ExtractFeatures({seen.width, seen.height, seen.grey}).value();
}

CorridorPair SeeSamePlaceTwice(const Corridor& corridor, std::uint64_t seed) {
  return SeeTwice(corridor, Noise(seed + 77).Uniform(-0.4, 0.4), seed);
}

CorridorPair SeeFromAhead(const Corridor& corridor, double ahead, std::uint64_t seed) {
  return SeeTwice(corridor, ahead, seed);
}

}  // namespace enfilade::testing
