// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "storage/sessions/session_store.h"

namespace enfilade::storage {

// All pages of SessionStore::List, newest first. Its errors.
absl::StatusOr<std::vector<Session>> ListAllSessions(const SessionStore& store, const CallContext& context,
                                                     const SiteId& site, const SessionFilter& filter);

}  // namespace enfilade::storage
