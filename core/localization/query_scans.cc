// SPDX-License-Identifier: Apache-2.0
#include "core/localization/query_scans.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::localization {
namespace {

absl::Status CheckScan(const QueryScan& query, std::size_t index, std::size_t count) {
  if (const absl::Status status = sensor::Validate(query.scan); !status.ok()) {
    return InvalidArgument("scans[{}]: {}", index, std::string(status.message()));
  }
  if (count > 1 && !query.T_odom_robot) {
    return InvalidArgument("scans[{}] has no odometry: several scans need it, each its own", index);
  }
  if (query.T_odom_robot && !IsFinite(*query.T_odom_robot)) {
    return InvalidArgument("scans[{}]: the odometry is not finite", index);
  }
  return absl::OkStatus();
}

bool HasHits(const TrackedScan& scan, const LocalizationOptions& options) {
  return scan.points.hits.size() >= static_cast<std::size_t>(options.min_hits);
}

}  // namespace

absl::StatusOr<std::vector<TrackedScan>> SelectScans(const std::vector<QueryScan>& scans,
                                                     const LocalizationOptions& options) {
  if (scans.empty()) return InvalidArgument("there are no scans");
  for (std::size_t i = 0; i < scans.size(); ++i) {
    ENFILADE_RETURN_IF_ERROR(CheckScan(scans[i], i, scans.size()));
  }
  std::vector<const QueryScan*> apart = {&scans.back()};
  for (auto it = std::next(scans.rbegin()); it != scans.rend(); ++it) {
    const Pose2 motion = Between(*apart.back()->T_odom_robot, *it->T_odom_robot);
    if (motion.translation().norm() < options.scan_spacing && std::abs(motion.yaw) < options.scan_spacing) continue;
    apart.push_back(&*it);
  }
  std::reverse(apart.begin(), apart.end());
  const std::size_t count = std::min(apart.size(), static_cast<std::size_t>(std::max(1, options.max_scans)));
  std::vector<TrackedScan> selected;
  for (std::size_t i = 0; i < count; ++i) {
    const QueryScan& one = *apart[(i + 1) * apart.size() / count - 1];  // the last one always
    selected.push_back({PointsOf(one.scan, options), one.T_odom_robot.value_or(Pose2())});
  }
  if (std::none_of(selected.begin(), selected.end(), [&](const TrackedScan& one) { return HasHits(one, options); })) {
    return InvalidArgument("no scan has {} hits on walls within {:.0f} m; the last one has {}", options.min_hits,
                           options.max_range, selected.back().points.hits.size());
  }
  return selected;
}

std::vector<std::size_t> ScansToSearch(const std::vector<TrackedScan>& scans, const LocalizationOptions& options) {
  std::vector<std::size_t> usable;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (HasHits(scans[i], options)) usable.push_back(i);
  }
  if (usable.empty()) return usable;
  std::vector<std::size_t> searched = {usable.front()};
  if (usable.size() >= 5) searched.push_back(usable[usable.size() / 2]);
  if (usable.size() >= 2) searched.push_back(usable.back());
  return searched;
}

}  // namespace enfilade::localization
