// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/noise.h"

namespace enfilade::simulator {

// Each reading of each sensor has its own generator, seeded by (seed, robot, sensor, index).
using enfilade::Mix;
using enfilade::Noise;
using enfilade::SeedOf;

}  // namespace enfilade::simulator
