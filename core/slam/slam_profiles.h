// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/slam/slam_options.h"

namespace enfilade::slam {

// SLAM options by name: each map is mapped with the one that suits it.
class SlamProfiles {
 public:
  static constexpr const char* kIndoor = "indoor";
  static constexpr const char* kOutdoor = "outdoor";

  // "indoor" is `base`. "outdoor" is the same seen farther, in larger submaps: what the predecessor's long-range
  // profile (range 50 m, 60 nodes in memory against 40) changes and this mapper has as well. Implicit: one set of
  // options is profiles enough.
  SlamProfiles(const SlamOptions& base = {});  // NOLINT(google-explicit-constructor)

  // Adds one, or takes the place of the one of that name.
  void Set(const std::string& name, const SlamOptions& options) { profiles_[name] = options; }

  // Null where there is none.
  const SlamOptions* Find(const std::string& name) const;
  // In the order of the alphabet.
  std::vector<std::string> Names() const;

 private:
  std::map<std::string, SlamOptions> profiles_;
};

}  // namespace enfilade::slam
