// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace enfilade {

// Nanoseconds since the Unix epoch, UTC. An integer, so that absolute acquisition times survive storage exactly
// (a double holds today's times only to 0.2 microseconds).
using TimeNs = std::int64_t;
// A span in nanoseconds.
using DurationNs = std::int64_t;

constexpr DurationNs kNsPerSecond = 1'000'000'000;

constexpr double ToSeconds(DurationNs duration) { return static_cast<double>(duration) * 1e-9; }
constexpr DurationNs DurationOf(double seconds) { return static_cast<DurationNs>(seconds * 1e9); }

}  // namespace enfilade
