// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace enfilade::testing {

// How many times as long as in a release build things take: what a wait is multiplied by.
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
inline constexpr int kSlowdown = 10;
#else
inline constexpr int kSlowdown = 1;
#endif

}  // namespace enfilade::testing
