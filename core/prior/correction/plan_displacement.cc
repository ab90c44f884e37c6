// SPDX-License-Identifier: Apache-2.0
#include "core/prior/correction/plan_displacement.h"

namespace enfilade::prior {

std::vector<std::vector<Eigen::Index>> MembersOf(const std::vector<int>& groups) {
  std::vector<std::vector<Eigen::Index>> members;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const auto group = static_cast<std::size_t>(groups[i]);
    if (members.size() <= group) members.resize(group + 1);
    members[group].push_back(static_cast<Eigen::Index>(i));
  }
  return members;
}

}  // namespace enfilade::prior
