// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/sensor/scan_pairing.h"

namespace enfilade::bench {

// All scans of a recorded log, paired with its odometry, or without any. Errors as LogReader's.
absl::StatusOr<std::vector<sensor::PairedScan>> ReadPairedScans(const std::string& path, bool odometry);

}  // namespace enfilade::bench
