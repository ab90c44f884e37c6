// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

namespace enfilade::bench {

// The processor time that a process has used, s. 0: there is no such process.
double ProcessorSeconds(pid_t pid);
// That of a process, of its children that run, and of those that have ended.
double ProcessorSecondsOfTree(pid_t root);

}  // namespace enfilade::bench
