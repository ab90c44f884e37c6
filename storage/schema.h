// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "storage/call_context.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

// Where the database stands in migrations/sqitch.plan as this program was built with it.
struct SchemaState {
  enum class Position {
    kEmpty,   // never migrated
    kBehind,  // `deployed` is an earlier change than `expected`: migrate
    kAtHead,
    kAhead,  // `deployed` is unknown to this program: a newer one has migrated
  };
  Position position = Position::kEmpty;
  std::string deployed;  // the last change deployed; empty for none
  std::string expected;  // the plan's last change
};

// UNAVAILABLE where the database cannot be reached.
absl::StatusOr<SchemaState> CheckSchema(const CallContext& context, postgres::Pool& pool);

}  // namespace enfilade::storage
