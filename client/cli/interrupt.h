// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace enfilade::cli {

// While it lives, Ctrl-C and SIGTERM do not end the program but are remembered, so that a command can end in order. A
// second one ends the program at once. One at a time.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  bool interrupted() const;
};

}  // namespace enfilade::cli
