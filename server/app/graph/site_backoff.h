// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <unordered_map>

#include "core/base/ids.h"

namespace enfilade::server {

// When a site whose work has failed is tried again: after 1 s, and twice as long after every further failure, up to a
// minute. Not thread-safe.
class SiteBackoff {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::seconds kFirst{1};
  static constexpr std::chrono::seconds kLongest{60};

  bool IsDue(const SiteId& site, Time now) const {
    const auto found = failures_.find(site);
    return found == failures_.end() || now >= found->second.next;
  }
  // Returns how long the site now waits.
  std::chrono::seconds Fail(const SiteId& site, Time now) {
    Failure& failure = failures_[site];
    failure.wait = failure.wait.count() == 0 ? kFirst : std::min(2 * failure.wait, kLongest);
    failure.next = now + failure.wait;
    return failure.wait;
  }
  void Succeed(const SiteId& site) { failures_.erase(site); }

 private:
  struct Failure {
    std::chrono::seconds wait{0};
    Time next;
  };
  std::unordered_map<SiteId, Failure> failures_;
};

}  // namespace enfilade::server
