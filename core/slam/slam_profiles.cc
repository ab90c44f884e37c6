// SPDX-License-Identifier: Apache-2.0
#include "core/slam/slam_profiles.h"

#include <algorithm>

namespace enfilade::slam {

SlamProfiles::SlamProfiles(const SlamOptions& base) {
  SlamOptions outdoor = base;
  outdoor.max_range = std::max(base.max_range, 50.0);
  outdoor.submap.max_keyframes = base.submap.max_keyframes * 3 / 2;
  profiles_ = {{kIndoor, base}, {kOutdoor, outdoor}};
}

const SlamOptions* SlamProfiles::Find(const std::string& name) const {
  const auto found = profiles_.find(name);
  return found == profiles_.end() ? nullptr : &found->second;
}

std::vector<std::string> SlamProfiles::Names() const {
  std::vector<std::string> names;
  for (const auto& [name, options] : profiles_) names.push_back(name);
  return names;
}

}  // namespace enfilade::slam
