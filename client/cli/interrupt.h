// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace enfilade::cli {

// While it exists, the first Ctrl-C or SIGTERM only sets a flag, so that a command can clean up before it ends. The
// second one ends the program. Only one may exist at a time.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  bool interrupted() const;
};

}  // namespace enfilade::cli
