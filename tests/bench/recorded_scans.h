#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/sensor/scan_pairing.h"

namespace enfilade {

// All scans of a recorded log, paired with its odometry, or without any. Errors as LogReader's.
absl::StatusOr<std::vector<PairedScan>> ReadPairedScans(const std::string& path, bool odometry);

}  // namespace enfilade
