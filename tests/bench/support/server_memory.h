// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nlohmann/json.hpp"
#include "tests/bench/support/bench_system.h"

namespace enfilade::bench {

// How much memory the server takes while robots send without a window and the database stores nothing for a while (its
// table is locked); then all of it is stored.
nlohmann::json MeasureServerMemory(BenchSystem& system);

}  // namespace enfilade::bench
