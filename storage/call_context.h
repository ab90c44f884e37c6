// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <stop_token>
#include <string>

namespace enfilade::storage {

// What every call of a store carries. At `deadline` the database gives up the statement (statement_timeout is set to
// the time that remains), and the caller gets DEADLINE_EXCEEDED. When `cancellation` is requested, the running
// statement is cancelled within a fraction of a second, and the caller gets CANCELLED.
struct CallContext {
  std::chrono::steady_clock::time_point deadline;
  std::string actor = {};             // who calls, for the audit trail; empty if unknown
  std::stop_token cancellation = {};  // never requested by default

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
