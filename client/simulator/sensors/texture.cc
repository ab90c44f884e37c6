// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "client/simulator/sensors/sensors.h"
#include "core/base/noise.h"

namespace enfilade::simulator {
namespace {

constexpr double kPosterCell = 0.7;  // m

float Fraction(std::uint64_t bits) { return static_cast<float>(bits >> 40) * 0x1.0p-24F; }

std::uint64_t CellHash(std::uint64_t seed, std::int64_t i, std::int64_t j) {
  return Mix(seed ^ (static_cast<std::uint64_t>(i) * 0x9E3779B97F4A7C15ULL) ^
             (static_cast<std::uint64_t>(j) * 0xC2B2AE3D27D4EB4FULL));
}

// Value noise in [-1, 1] on a lattice of `size` m, smooth between.
float LatticeNoise(std::uint64_t seed, double u, double v, double size) {
  const double x = u / size;
  const double y = v / size;
  const auto i = static_cast<std::int64_t>(std::floor(x));
  const auto j = static_cast<std::int64_t>(std::floor(y));
  const auto smooth = [](double t) { return static_cast<float>(t * t * (3.0 - 2.0 * t)); };
  const float a = smooth(x - static_cast<double>(i));
  const float b = smooth(y - static_cast<double>(j));
  const float low = Fraction(CellHash(seed, i, j)) * (1.0F - a) + Fraction(CellHash(seed, i + 1, j)) * a;
  const float high = Fraction(CellHash(seed, i, j + 1)) * (1.0F - a) + Fraction(CellHash(seed, i + 1, j + 1)) * a;
  return 2.0F * (low * (1.0F - b) + high * b) - 1.0F;
}

// A poster in some of the cells: a frame with squares of black and white in it, as corners and blobs for features.
// In [-1, 1]; 0 beside posters.
float Poster(std::uint64_t seed, double u, double v, double footprint) {
  const auto i = static_cast<std::int64_t>(std::floor(u / kPosterCell));
  const auto j = static_cast<std::int64_t>(std::floor(v / kPosterCell));
  const std::uint64_t cell = CellHash(seed, i, j);
  if (Fraction(cell) > 0.6F) return 0.0F;
  Noise noise(cell);
  const double width = noise.Uniform(0.25, 0.6);
  const double height = noise.Uniform(0.25, 0.6);
  const double left = noise.Uniform(0.0, kPosterCell - width);
  const double bottom = noise.Uniform(0.0, kPosterCell - height);
  const double x = (u - static_cast<double>(i) * kPosterCell - left) / width;
  const double y = (v - static_cast<double>(j) * kPosterCell - bottom) / height;
  if (x < 0.0 || x >= 1.0 || y < 0.0 || y >= 1.0) return 0.0F;
  const auto ground = static_cast<float>(noise.Uniform(-0.8, 0.8));
  const int columns = 3 + noise.Below(4);
  const int rows = 3 + noise.Below(4);
  if (footprint > width / columns) return ground * 0.5F;
  const int column = static_cast<int>(x * columns);
  const int row = static_cast<int>(y * rows);
  const std::uint64_t square = CellHash(cell, column, row);
  if ((square & 1U) == 0) return ground;
  const auto ink = static_cast<float>(ground > 0.0F ? -0.9 : 0.9);
  if ((square & 2U) == 0) return ink;
  const double dx = x * columns - column - 0.5;  // a disc
  const double dy = y * rows - row - 0.5;
  return dx * dx + dy * dy < 0.16 ? ink : ground;
}

float Shown(double size, double footprint) {
  return static_cast<float>(std::clamp(1.5 - footprint / size * 1.5, 0.0, 1.0));
}

}  // namespace

float BrightnessOf(const Paint& paint, double u, double v, double footprint) {
  if (paint.period > 0.0F) u -= std::floor(u / paint.period) * paint.period;
  float value = 0.25F * LatticeNoise(paint.seed + 1, u, v, 1.5);
  constexpr double kSizes[] = {0.30, 0.11, 0.04};
  constexpr float kStrengths[] = {0.30F, 0.35F, 0.30F};
  for (int octave = 0; octave < 3; ++octave) {
    const float shown = Shown(kSizes[octave], footprint);
    if (shown <= 0.0F) break;
    value +=
        shown * kStrengths[octave] * LatticeNoise(paint.seed + 2 + static_cast<unsigned>(octave), u, v, kSizes[octave]);
  }
  value += 0.7F * Poster(paint.seed + 7, u, v, footprint);
  return std::clamp(paint.brightness + 0.4F * paint.contrast * value, 0.02F, 1.0F);
}

}  // namespace enfilade::simulator
