// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <random>

namespace enfilade::client {

// How long to wait before the next attempt: doubles from `min_s` to `max_s`. Each wait is drawn from the upper half of
// that, so that a fleet that lost its server does not come back all at the same moment.
class Backoff {
 public:
  Backoff(double min_s, double max_s, std::uint64_t seed)
      : min_s_(min_s), max_s_(max_s), next_s_(min_s), random_(seed) {}

  double NextSeconds();
  // After a success.
  void Reset() { next_s_ = min_s_; }

 private:
  double min_s_;
  double max_s_;
  double next_s_;
  std::mt19937_64 random_;
};

}  // namespace enfilade::client
