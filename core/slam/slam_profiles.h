// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/slam/slam_options.h"

namespace enfilade::slam {

// SLAM options by name, so that each map can be mapped with suitable ones.
class SlamProfiles {
 public:
  static constexpr const char* kIndoor = "indoor";
  static constexpr const char* kOutdoor = "outdoor";

  // "indoor" is `base`. "outdoor" is `base` with a range of at least 50 m and submaps of half as many keyframes more.
  // Implicit, so that one set of options can be passed as profiles.
  SlamProfiles(const SlamOptions& base = {});  // NOLINT(google-explicit-constructor)

  // Adds a profile, or replaces the one of that name.
  void Set(const std::string& name, const SlamOptions& options) { profiles_[name] = options; }

  // Null if there is no profile of that name.
  const SlamOptions* Find(const std::string& name) const;
  // In alphabetical order.
  std::vector<std::string> Names() const;

 private:
  std::map<std::string, SlamOptions> profiles_;
};

}  // namespace enfilade::slam
