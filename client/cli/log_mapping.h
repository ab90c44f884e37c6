// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cli/command.h"
#include "client/sources/log_reader.h"
#include "core/sensor/scan_pairing.h"
#include "core/slam/mapper/log_mapper.h"

namespace enfilade::cli {

// Maps what is left of a log, to its end, with a progress bar. Returns the time that mapping took, without reading.
absl::StatusOr<std::chrono::steady_clock::duration> MapToEnd(const Globals& globals, sources::LogReader& reader,
                                                             slam::LogMapper& mapper);

// The scans of what is left of a log, paired with its odometry as LogMapper does.
absl::StatusOr<std::vector<sensor::PairedScan>> ReadScans(sources::LogReader& reader);

}  // namespace enfilade::cli
