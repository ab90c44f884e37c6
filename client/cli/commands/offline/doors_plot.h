// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/doors/door_event.h"
#include "core/doors/door_options.h"
#include "core/sensor/scan_pairing.h"

namespace enfilade::cli {

// A PNG of two pictures. Above: the derivative of each scan as a column of pixels (time to the right, bearing upwards;
// red: the range jumps up, blue: down), with latched doors (orange), candidates (grey) and passages (green) as vertical
// lines. Below: the path in the odometry frame over the hits of the scans, with passages as green bars as wide as the
// door, and candidates as orange crosses.
absl::StatusOr<std::string> DrawDoors(const std::vector<sensor::PairedScan>& scans,
                                      const std::vector<doors::DoorEvent>& events,
                                      const doors::DerivativeOptions& options);

}  // namespace enfilade::cli
