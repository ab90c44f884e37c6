// SPDX-License-Identifier: Apache-2.0
#include "core/graph/same_place.h"

#include <algorithm>

#include "core/graph/search_radius.h"

namespace enfilade::graph {

double SamePlaceDistance(const Eigen::Matrix3d& covariance_a, const Eigen::Matrix3d& covariance_b) {
  return std::max(kMinSamePlaceDistance, ErrorEllipse95(covariance_a + covariance_b).semi_major_m);
}

std::optional<CommonPlace> FindCommonPlace(const std::vector<Anchor>& a, const std::vector<Anchor>& b) {
  CommonPlace place;
  for (const Anchor& anchor : a) {
    const auto other =
        std::find_if(b.begin(), b.end(), [&](const Anchor& candidate) { return candidate.map == anchor.map; });
    if (other == b.end()) continue;
    const double distance = (anchor.T_map_place.translation() - other->T_map_place.translation()).norm();
    if (!(distance <= SamePlaceDistance(anchor.covariance, other->covariance))) return std::nullopt;
    ++place.map_count;
    place.distance = std::max(place.distance, distance);
  }
  if (place.map_count < 2) return std::nullopt;
  return place;
}

}  // namespace enfilade::graph
