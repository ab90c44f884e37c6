// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "client/cli/command.h"
#include "client/sources/log_reader.h"
#include "core/prior/localization/mapped_drive.h"

namespace enfilade::cli {

// Maps the log to its end, with a progress bar. INVALID_ARGUMENT: no scan could be mapped; errors of the reader.
absl::StatusOr<prior::MappedDrive> MapDrive(const Globals& globals, const std::string& log,
                                            const sources::LogOptions& reading);

}  // namespace enfilade::cli
