// SPDX-License-Identifier: Apache-2.0
#include "core/localization/located_drive.h"

#include <cmath>
#include <cstddef>

namespace enfilade::localization {
namespace {

bool Agree(const LocatedMoment& a, const LocatedMoment& b, const LocatedDriveOptions& options) {
  const Pose2 predicted = a.T_map_robot.pose * Between(a.T_odom_robot, b.T_odom_robot);
  const Pose2 off = Between(predicted, b.T_map_robot.pose);
  const double driven = b.travelled - a.travelled;
  return off.translation().norm() <= options.distance + options.distance_per_metre * driven &&
         std::abs(off.yaw) <= options.angle + options.angle_per_metre * driven;
}

}  // namespace

std::optional<LocatedMoment> FindStart(const std::vector<LocatedMoment>& moments, double travelled,
                                       const LocatedDriveOptions& options) {
  if (moments.empty()) return std::nullopt;
  if (moments.size() == 1 && travelled > options.one_is_enough) return std::nullopt;
  for (std::size_t i = 1; i < moments.size(); ++i) {
    if (!Agree(moments[i - 1], moments[i], options)) return std::nullopt;
  }
  return moments.front();
}

}  // namespace enfilade::localization
