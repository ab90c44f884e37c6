// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/resource.h>

namespace enfilade::server {

// Of threads whose work nobody waits for at the moment: beside a busy ordinary one they get a quarter of a processor.
constexpr int kBackgroundNiceness = 5;

// Makes the calling thread leave the processors to others. `niceness`: 0 to 19; it cannot be taken back. On Linux it
// holds for this thread only (setpriority(2), "C library/kernel differences").
inline void SetThreadNiceness(int niceness) {
  if (niceness != 0) setpriority(PRIO_PROCESS, 0, niceness);
}

}  // namespace enfilade::server
