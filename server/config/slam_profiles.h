// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "core/slam/slam_profiles.h"
#include "server/config/server_options.h"

namespace enfilade::server {

// Reads the files that mapping.slam_options_file and mapping.slam_profiles_directory name. Errors name the file or the
// option.
absl::StatusOr<slam::SlamProfiles> LoadSlamProfiles(const ServerOptions::Mapping& options);

}  // namespace enfilade::server
