// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "storage/graph/rearrangement_store.h"
#include "tests/fakes/in_memory_database.h"

namespace enfilade::testing {

// What InMemoryRearrangementStore does, step by step. `version`: of the graph, which the step makes.

// The site's rows while it is rearranged.
struct RearrangedSite {
  InMemoryDatabase::Access& access;
  const SiteId& id;
  SiteRows& rows;
  std::int64_t version = 0;
};

// Errors as RearrangementStore::Apply. `row` has the rearrangement's parts.
absl::Status CheckRearranged(const RearrangedSite& site, const storage::RearrangementChange& change,
                             const RearrangementRow& row);
// Changes the rows; on an error some are changed, and the caller puts them back.
absl::Status ApplyRearrangement(const RearrangedSite& site, const storage::RearrangementChange& change,
                                RearrangementRow& row);

// Errors as RearrangementStore::Undo.
absl::Status CheckUnchanged(const RearrangedSite& site, const RearrangementRow& row);
void UndoRearrangement(const RearrangedSite& site, const RearrangementRow& row);

}  // namespace enfilade::testing
