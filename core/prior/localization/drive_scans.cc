// SPDX-License-Identifier: Apache-2.0
#include "core/prior/localization/drive_scans.h"

#include <algorithm>
#include <cstddef>
#include <string>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/base/time.h"

namespace enfilade::prior {
namespace {

absl::Status CheckDriveScan(const sensor::PairedScan& scan, std::size_t index) {
  if (const absl::Status status = sensor::Validate(scan.scan); !status.ok()) {
    return InvalidArgument("scans[{}]: {}", index, std::string(status.message()));
  }
  if (!scan.T_odom_robot) return InvalidArgument("scans[{}] has no odometry", index);
  if (!IsFinite(*scan.T_odom_robot)) return InvalidArgument("scans[{}]: the odometry is not finite", index);
  return absl::OkStatus();
}

// From scan `index` - 1 to scan `index`.
absl::Status CheckStep(double metres, double seconds, std::size_t index, const DriveScanRules& rules) {
  if (seconds < 0) {
    return InvalidArgument("scans[{}] was taken {:.3f} s before scans[{}]: expected them in order of time", index,
                           -seconds, index - 1);
  }
  if (metres > rules.longest_step) {
    return InvalidArgument(
        "scans[{}] is {:.1f} m from scans[{}] by odometry: expected scans of one robot, at most {:.0f} m apart", index,
        metres, index - 1, rules.longest_step);
  }
  if (seconds > 0 && metres > rules.fastest * seconds) {
    return InvalidArgument(
        "from scans[{}] to scans[{}] the odometry moves by {:.2f} m in {:.3f} s: expected scans of one robot, at most "
        "{:.0f} m/s",
        index - 1, index, metres, seconds, rules.fastest);
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckDriveScans(const std::vector<sensor::PairedScan>& scans, const DriveScanRules& rules) {
  if (scans.empty()) return InvalidArgument("there are no scans");
  double travelled = 0;
  std::size_t most_hits = 0;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    ENFILADE_RETURN_IF_ERROR(CheckDriveScan(scans[i], i));
    most_hits = std::max(most_hits, sensor::CountBeams(scans[i].scan).hits);
    if (i == 0) continue;
    const double metres = Between(*scans[i - 1].T_odom_robot, *scans[i].T_odom_robot).translation().norm();
    ENFILADE_RETURN_IF_ERROR(CheckStep(metres, ToSeconds(scans[i].scan.time - scans[i - 1].scan.time), i, rules));
    travelled += metres;
  }
  if (most_hits < static_cast<std::size_t>(rules.min_hits)) {
    return InvalidArgument("no scan has {} hits: the best one has {}", rules.min_hits, most_hits);
  }
  if (travelled < rules.least_distance) {
    return InvalidArgument("the robot drove {:.1f} m from the first scan to the last: {:.0f} m are needed", travelled,
                           rules.least_distance);
  }
  return absl::OkStatus();
}

}  // namespace enfilade::prior
