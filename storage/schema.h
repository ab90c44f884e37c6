// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "storage/call_context.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

// The position of the database in migrations/sqitch.plan as of the build of this program.
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

// UNAVAILABLE if the database cannot be reached.
absl::StatusOr<SchemaState> CheckSchema(const CallContext& context, postgres::Pool& pool);

}  // namespace enfilade::storage
