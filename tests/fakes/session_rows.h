// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/fakes/in_memory_tables.h"

namespace enfilade::testing {

// The session with the progress of its mapping.
storage::Session WithProgress(const SessionRow& row);
// Lets the session wait for its turn, if there is something to map.
void QueueWork(SessionRow& row, std::chrono::steady_clock::time_point now);
// A session that is created in a map which was merged goes to the map that it leads to, in its frame.
void FollowRedirect(const SiteRows& site, storage::Session& session);
// What the session has mapped, in a frame in which that of its map has the pose `T_to_from`.
void MoveSession(SessionRow& row, const rearrange::SessionMove& move);
// The session's records from each cut on, up to the next one, with what was mapped by them, become a session of its
// own. Loop closures across a cut are dropped.
void CutSessions(SiteRows& site, std::vector<rearrange::SessionCut> cuts);
// Takes the rest back. `before`: the session as it was before the cut.
void UncutSession(SiteRows& site, const rearrange::SessionCut& cut, const SessionRow& before);
// Whoever holds its lease has lost it.
void DeleteSession(SessionRow& row);

}  // namespace enfilade::testing
