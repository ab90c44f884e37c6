// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace enfilade::slam {

// What is known of how large SLAM's errors are, compared with the standard deviations that its options state. Those
// decide how measurements are weighed and which loop closures are believed; but clean scans of smooth walls are several
// times more accurate than they say, and no option can know that.
struct ErrorStatistics {
  double match_squares = 0.0;   // over keyframes: squared residual of the match in units of FieldMatchOptions::sigma
  std::int64_t matches = 0;     // keyframes
  double graph_chi2 = 0.0;      // of the pose graph's last solution
  std::int64_t redundancy = 0;  // its degrees of freedom: 3 for each accepted loop closure

  friend bool operator==(const ErrorStatistics&, const ErrorStatistics&) = default;
};

// The variance of unit weight: covariances that follow from the options' standard deviations are to be multiplied by
// it (Foerstner, Wrobel 2016: Photogrammetric Computer Vision, eq. 4.90). The matches' residuals stand for the pose
// graph's where that has no or few loop closures. Closures of neighbouring keyframes match nearly the same walls and
// share a part of their errors: together they prove less than their number says. 1 if nothing is known.
double VarianceFactor(const ErrorStatistics& statistics);

}  // namespace enfilade::slam
