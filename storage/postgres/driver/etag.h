// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace enfilade::storage::postgres {

// The etag of a row's new version: positive and random, so that it is unique without a counter that all nodes of a
// database would share. New rows may have the database's default instead. Thread-safe.
std::int64_t NewEtag();

}  // namespace enfilade::storage::postgres
