// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/map_entries.h"

#include <chrono>
#include <utility>

namespace enfilade::server {
namespace {

constexpr auto kEntryTimeout = std::chrono::seconds(10);
// Verdicts of other replicas are found by polling.
constexpr auto kEntryPoll = std::chrono::seconds(1);

storage::CallContext EntryContext() { return storage::CallContext::WithTimeout(kEntryTimeout); }

}  // namespace

MapEntries::MapEntries(const storage::SessionStore& sessions, const storage::MapStore& maps,
                       const storage::DoorVerdictStore& verdicts)
    : sessions_(sessions), maps_(maps), verdicts_(verdicts) {
  worker_ = std::thread([this] { Run(); });
}

MapEntries::~MapEntries() {
  stop_.Set();
  wake_.Wake();
  worker_.join();
}

void MapEntries::Await(const convert::SessionName& session, std::weak_ptr<const void> owner,
                       std::function<void(const MapEntry&)> on_entry) {
  {
    MutexLock lock(mutex_);
    waiting_.push_back({session, std::move(owner), std::move(on_entry)});
  }
  wake_.Wake();
}

void MapEntries::Run() {
  while (true) {
    wake_.WaitFor(kEntryPoll);
    if (stop_.is_set()) return;
    std::list<Waiting> waiting;
    {
      MutexLock lock(mutex_);
      waiting.swap(waiting_);
    }
    waiting.remove_if([&](const Waiting& one) { return stop_.is_set() || Notify(one); });
    MutexLock lock(mutex_);
    waiting_.splice(waiting_.end(), waiting);
  }
}

bool MapEntries::Notify(const Waiting& waiting) const {
  if (waiting.owner.expired()) return true;
  const auto session = sessions_.Get(EntryContext(), waiting.session.site, waiting.session.session);
  if (!session.ok()) return absl::IsNotFound(session.status());
  if (!session->map) return false;
  const auto map = maps_.Get(EntryContext(), waiting.session.site, *session->map);
  if (!map.ok()) return absl::IsNotFound(map.status());
  MapEntry entry{*map, session->entry, {}};
  if (session->entry.previous) {
    auto verdict = verdicts_.FindPassage(EntryContext(), waiting.session.site, *session->entry.previous);
    if (!verdict.ok()) return false;
    entry.verdict = *std::move(verdict);
  }
  waiting.on_entry(entry);
  return true;
}

}  // namespace enfilade::server
