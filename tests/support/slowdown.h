// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace enfilade::testing {

// How much slower than a release build this build is: a factor for timeouts.
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
inline constexpr int kSlowdown = 10;
#else
inline constexpr int kSlowdown = 1;
#endif

}  // namespace enfilade::testing
