// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/closure/closure_options.h"
#include "core/geometry/pose2.h"

namespace enfilade::closure {

// Of two independent estimates of one pose in one frame: e' (S_a + S_b + diag(sigma^2, sigma^2, yaw_sigma^2))^-1 e with
// e = (dx, dy, dyaw), yaw wrapped. Chi-squared with 3 degrees of freedom if both are right.
double PoseChiSquared(const PoseWithCovariance& a, const PoseWithCovariance& b, double sigma, double yaw_sigma);

// A door can be seen from both sides: the lesser of the values of `a` and of `a` turned by 180 degrees.
double PlaceChiSquared(const PoseWithCovariance& a, const PoseWithCovariance& b, const DoorClosureOptions& options);

// What chi-squared with 3 degrees of freedom must not exceed: its quantiles at gate_probability, strict_probability.
double Gate(const DoorClosureOptions& options);
double StrictGate(const DoorClosureOptions& options);

// The same place, seen from the other side.
PoseWithCovariance Turned(const PoseWithCovariance& T_map_place);

}  // namespace enfilade::closure
