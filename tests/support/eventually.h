// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <thread>

#include "tests/support/slowdown.h"

namespace enfilade::testing {

// Waits until `condition` holds. False after `limit`, which is far longer than anything takes even on a busy machine,
// so that only a failing test waits for it.
template <typename Condition>
bool Eventually(const Condition& condition, std::chrono::seconds limit = std::chrono::seconds(180 * kSlowdown)) {
  const auto end = std::chrono::steady_clock::now() + limit;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

}  // namespace enfilade::testing
