// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/fakes/in_memory_tables.h"

namespace enfilade::testing {

// The session with the progress of its mapping.
storage::Session WithProgress(const SessionRow& row);
// Whoever holds its lease has lost it.
void DeleteSession(SessionRow& row);

}  // namespace enfilade::testing
