// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>

namespace enfilade::storage {

// What every call of a store carries. The database gives up a statement when `deadline` passes (statement_timeout is
// set to what remains), and the caller gets DEADLINE_EXCEEDED.
struct CallContext {
  std::chrono::steady_clock::time_point deadline;
  std::string actor = {};  // who calls, for the audit trail; empty where nobody said

  static CallContext WithTimeout(std::chrono::steady_clock::duration timeout) {
    return {.deadline = std::chrono::steady_clock::now() + timeout};
  }
};

// One page of a list ordered by key. Stable under changes: a row that stays is neither skipped nor given twice.
struct PageRequest {
  int limit = 100;
  std::string after;  // the last id of the page before; empty for the first page
};

}  // namespace enfilade::storage
