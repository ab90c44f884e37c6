// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/driver/etag.h"

#include <limits>
#include <random>

namespace enfilade::storage::postgres {

std::int64_t NewEtag() {
  thread_local std::mt19937_64 generator = [] {
    std::random_device entropy;
    std::seed_seq seed{entropy(), entropy(), entropy(), entropy(), entropy(), entropy(), entropy(), entropy()};
    return std::mt19937_64(seed);
  }();
  return std::uniform_int_distribution<std::int64_t>(1, std::numeric_limits<std::int64_t>::max())(generator);
}

}  // namespace enfilade::storage::postgres
