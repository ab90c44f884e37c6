// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <string_view>

namespace enfilade {

// The finaliser of SplitMix64 (Steele, Lea, Flood 2014): every bit of the input moves every bit of the result.
constexpr std::uint64_t Mix(std::uint64_t value) {
  value += 0x9E3779B97F4A7C15ULL;
  value = (value ^ (value >> 30)) * 0xBF58476D1CE4E5B9ULL;
  value = (value ^ (value >> 27)) * 0x94D049BB133111EBULL;
  return value ^ (value >> 31);
}
constexpr std::uint64_t Mix(std::uint64_t a, std::uint64_t b) { return Mix(Mix(a) ^ b); }
constexpr std::uint64_t Mix(std::uint64_t a, std::uint64_t b, std::uint64_t c) { return Mix(Mix(a, b), c); }

// The seed of a text (FNV-1a).
constexpr std::uint64_t SeedOf(std::string_view text) {
  std::uint64_t hash = 0xCBF29CE484222325ULL;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3ULL;
  return hash;
}

// Random numbers that are the same with every standard library (std::normal_distribution is not): SplitMix64. A
// generator is cheap to construct: each reading of a simulated sensor, or each particle of a filter at each step, has
// its own, seeded by a mix of what it is for, so that nothing depends on what was drawn before it.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : state_(Mix(seed)) {}

  // In [0, 1).
  double Uniform() { return static_cast<double>(Bits() >> 11) * 0x1.0p-53; }
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  // In [0, count).
  int Below(int count) { return static_cast<int>(Uniform() * count); }
  bool Chance(double probability) { return Uniform() < probability; }
  // Standard normal (Box and Muller 1958).
  double Normal() { return std::sqrt(-2.0 * std::log(1.0 - Uniform())) * std::cos(2.0 * M_PI * Uniform()); }

 private:
  std::uint64_t Bits() {
    state_ += 0x9E3779B97F4A7C15ULL;
    return Mix(state_);
  }

  std::uint64_t state_;
};

}  // namespace enfilade
