// SPDX-License-Identifier: Apache-2.0
#include "server/config/slam_profiles.h"

#include <filesystem>
#include <string>
#include <system_error>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/slam/slam_options_yaml.h"
#include "io/file.h"

namespace enfilade::server {

absl::StatusOr<slam::SlamProfiles> LoadSlamProfiles(const ServerOptions::Mapping& options) {
  const auto read = [](const std::filesystem::path& path) -> absl::StatusOr<slam::SlamOptions> {
    ENFILADE_ASSIGN_OR_RETURN(const std::string text, io::ReadFile(path));
    return slam::ParseSlamOptions(text, path.string());
  };
  slam::SlamOptions base;
  if (!options.slam_options_file.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(base, read(options.slam_options_file));
  }
  slam::SlamProfiles profiles(base);
  if (options.slam_profiles_directory.empty()) return profiles;
  std::error_code error;
  for (const auto& file : std::filesystem::directory_iterator(options.slam_profiles_directory, error)) {
    if (file.path().extension() != ".yaml") continue;
    ENFILADE_ASSIGN_OR_RETURN(const slam::SlamOptions slam, read(file.path()));
    profiles.Set(file.path().stem(), slam);
  }
  if (error) {
    return NotFound("mapping.slam_profiles_directory: {}: {}", options.slam_profiles_directory, error.message());
  }
  return profiles;
}

}  // namespace enfilade::server
