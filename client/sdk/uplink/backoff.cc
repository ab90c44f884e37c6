// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/uplink/backoff.h"

#include <algorithm>

namespace enfilade::client {

double Backoff::NextSeconds() {
  const double whole = next_s_;
  next_s_ = std::min(2.0 * next_s_, max_s_);
  const double share = 0.5 + 0.5 * static_cast<double>(random_() >> 11) * 0x1.0p-53;
  return whole * share;
}

}  // namespace enfilade::client
