// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "storage/call_context.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

// The position of the database in migrations/sqitch.plan as of the build of a program.
struct SchemaState {
  enum class Position {
    kEmpty,   // never migrated
    kBehind,  // `deployed` is an earlier change than `expected`: migrate
    kAtHead,
    kAhead,   // a newer program has migrated, and all of its changes allow this one to serve
    kTooNew,  // one of them, `breaking`, does not
  };
  Position position = Position::kEmpty;
  std::string deployed;       // the last change deployed; empty for none
  std::string expected;       // the plan's last change
  std::string breaking = {};  // of kTooNew
  std::string required = {};  // of kTooNew: the last change that the oldest program for `breaking` knows
};

// The changes that this program knows: migrations/sqitch.plan as of its build.
absl::Span<const std::string_view> KnownChanges();

// The state for a program that knows `known`. UNAVAILABLE if the database cannot be reached.
absl::StatusOr<SchemaState> CheckSchema(const CallContext& context, postgres::Pool& pool,
                                        absl::Span<const std::string_view> known = KnownChanges());

}  // namespace enfilade::storage
