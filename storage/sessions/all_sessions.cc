// SPDX-License-Identifier: Apache-2.0
#include "storage/sessions/all_sessions.h"

#include <iterator>
#include <optional>
#include <utility>

#include "core/base/status_macros.h"

namespace enfilade::storage {

absl::StatusOr<std::vector<Session>> ListAllSessions(const SessionStore& store, const CallContext& context,
                                                     const SiteId& site, const SessionFilter& filter) {
  constexpr int kPage = 500;
  std::vector<Session> sessions;
  std::optional<SessionPosition> after;
  while (true) {
    ENFILADE_ASSIGN_OR_RETURN(std::vector<Session> page, store.List(context, site, filter, kPage, after));
    const bool last = page.size() < kPage;
    if (!page.empty()) after = SessionPosition{page.back().create_time, page.back().id};
    std::move(page.begin(), page.end(), std::back_inserter(sessions));
    if (last) return sessions;
  }
}

}  // namespace enfilade::storage
