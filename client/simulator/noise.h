#pragma once

#include <cmath>
#include <cstdint>
#include <random>

namespace enfilade::simulator {

// Random numbers that are the same with every standard library (std::normal_distribution is not).
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : random_(seed) {}

  // In [0, 1).
  double Uniform() { return static_cast<double>(random_() >> 11) * 0x1.0p-53; }
  // Standard normal (Box and Muller 1958).
  double Normal() { return std::sqrt(-2.0 * std::log(1.0 - Uniform())) * std::cos(2.0 * M_PI * Uniform()); }

 private:
  std::mt19937_64 random_;
};

}  // namespace enfilade::simulator
