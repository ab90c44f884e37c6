// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/site_graphs.h"

#include <deque>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/app/graph/site_graph_reader.h"
#include "spdlog/spdlog.h"

namespace enfilade::server {
namespace {

using std::chrono::steady_clock;

constexpr std::size_t kKeptVersions = 8;
// Beyond them, a version that is asked for by its number is kept for so long, among at most so many.
constexpr auto kKeptInUse = std::chrono::seconds(60);
constexpr std::size_t kMaxKeptInUse = 64;
// Sites whose graphs are read at the same time.
constexpr int kReaders = 3;
// Continuations that wait for graphs, of all sites.
constexpr std::size_t kMaxWaitingReads = 1000;
constexpr auto kListenTimeout = std::chrono::milliseconds(500);
constexpr auto kReadTimeout = std::chrono::seconds(30);
constexpr auto kConnectTimeout = std::chrono::seconds(5);
// Of versions that may have changed without a notification.
constexpr auto kCheckInterval = std::chrono::seconds(1);
constexpr auto kReconnectInterval = std::chrono::seconds(1);

// Lets a thread wait for a read.
class AwaitedRead {
 public:
  void Set(const SiteGraphs::Result& result) {
    MutexLock lock(mutex_);
    result_ = result;
    changed_.NotifyAll();
  }
  SiteGraphs::Result Await(const storage::CallContext& context) {
    const std::stop_callback on_cancel(context.cancellation, [this] {
      MutexLock lock(mutex_);
      changed_.NotifyAll();
    });
    MutexLock lock(mutex_);
    while (!result_.has_value()) {
      if (context.cancellation.stop_requested()) return absl::CancelledError("the caller no longer waits");
      if (changed_.WaitUntil(mutex_, context.deadline) || result_.has_value()) continue;
      return absl::DeadlineExceededError("the deadline passed while the graph was read");
    }
    return *result_;
  }

 private:
  Mutex mutex_;
  CondVar changed_;
  std::optional<SiteGraphs::Result> result_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace

SiteGraphs::SiteGraphs(const storage::GraphStore& store, ChangedSites& changed)
    : store_(store), changed_(changed), readers_(kReaders, kMaxWaitingReads) {
  listener_ = std::thread([this] { Listen(); });
}

SiteGraphs::~SiteGraphs() {
  Stop();
  abandoned_.request_stop();
  listener_.join();
  readers_.Stop();
}

void SiteGraphs::Stop() { stop_.Set(); }

std::shared_ptr<const SiteGraph> SiteGraphs::FindCurrent(const SiteId& site) const {
  MutexLock lock(mutex_);
  const auto found = entries_.find(site);
  if (found == entries_.end() || !listening_) return nullptr;
  const Entry& entry = *found->second;
  return entry.changes_read >= entry.changes_needed ? entry.current : nullptr;
}

SiteGraphs::Result SiteGraphs::Get(const storage::CallContext& context, const SiteId& site) {
  if (std::shared_ptr<const SiteGraph> current = FindCurrent(site)) return current;
  const auto read = std::make_shared<AwaitedRead>();
  ReadFor(site, [read](const Result& result) { read->Set(result); });
  return read->Await(context);
}

void SiteGraphs::Prepare(const SiteId& site, std::function<void(const absl::Status&)> then) {
  if (FindCurrent(site) != nullptr) return then(absl::OkStatus());
  if (++waiting_ > kMaxWaitingReads) {
    --waiting_;
    return then(ResourceExhausted("too many calls wait for graphs that are being read: try again later"));
  }
  ReadFor(site, [this, then = std::move(then)](const Result& result) {
    --waiting_;
    then(result.status());
  });
}

void SiteGraphs::Refresh(const SiteId& site, std::function<void(const Result&)> then) {
  {
    MutexLock lock(mutex_);
    const auto found = entries_.find(site);
    if (found != entries_.end()) ++found->second->changes;
  }
  ReadFor(site, std::move(then));
}

void SiteGraphs::ReadFor(const SiteId& site, Waiter waiter) {
  std::shared_ptr<Entry> entry;
  {
    MutexLock lock(mutex_);
    std::shared_ptr<Entry>& found = entries_[site];
    if (found == nullptr) found = std::make_shared<Entry>();
    entry = found;
    entry->waiters.push_back(std::move(waiter));
    if (std::exchange(entry->reading, true)) return;
  }
  readers_.PostNext([this, site, entry] { BringUpToDate(site, entry); });
}

// Those who come while it reads wait for the next read, which often finds that nothing has changed: what they must see
// may be newer than what has been read.
void SiteGraphs::BringUpToDate(const SiteId& site, const std::shared_ptr<Entry>& entry) {
  std::vector<Waiter> waiters;
  std::shared_ptr<const SiteGraph> old;
  std::uint64_t changes = 0;
  bool known = false;
  {
    MutexLock lock(mutex_);
    waiters = std::exchange(entry->waiters, {});
    old = entry->current;
    changes = entry->changes;
    known = listening_ && old != nullptr && entry->changes_read == changes;
  }
  Result read = old;
  if (!known) {
    storage::CallContext context = storage::CallContext::WithTimeout(kReadTimeout);
    context.cancellation = abandoned_.get_token();
    read = ReadSiteGraph(store_, context, site, old);
    Keep(site, *entry, changes, read);
  }
  for (const Waiter& waiter : waiters) waiter(read);
  {
    MutexLock lock(mutex_);
    entry->reading = !entry->waiters.empty();
    if (!entry->reading) return;
  }
  readers_.PostNext([this, site, entry] { BringUpToDate(site, entry); });
}

void SiteGraphs::Keep(const SiteId& site, Entry& entry, std::uint64_t changes, const Result& read) {
  {
    MutexLock lock(mutex_);
    if (!read.ok()) {
      const auto found = entries_.find(site);
      if (absl::IsNotFound(read.status()) && found != entries_.end() && found->second.get() == &entry) {
        entries_.erase(found);
      }
      return;
    }
    entry.changes_read = changes;
    if (*read == entry.current) return;
    entry.current = *read;
    entry.recent.push_front({*read});
    ForgetOldVersions(entry.recent);
  }
  changed_.Add(site);
}

void SiteGraphs::ForgetOldVersions(std::deque<KeptVersion>& recent) {
  const auto since = std::chrono::steady_clock::now() - kKeptInUse;
  std::size_t age = 0;
  std::erase_if(recent, [&](const KeptVersion& kept) {
    ++age;
    return age > kMaxKeptInUse || (age > kKeptVersions && kept.asked_for < since);
  });
}

SiteGraphs::Result SiteGraphs::GetVersion(const storage::CallContext& context, const SiteId& site,
                                          std::int64_t version) {
  ENFILADE_ASSIGN_OR_RETURN(std::shared_ptr<const SiteGraph> current, Get(context, site));
  if (version == 0) return current;
  MutexLock lock(mutex_);
  const auto entry = entries_.find(site);
  if (entry != entries_.end()) {
    for (KeptVersion& kept : entry->second->recent) {
      if (kept.graph->graph().version() != version) continue;
      kept.asked_for = std::chrono::steady_clock::now();
      return kept.graph;
    }
  }
  return NotFound("the graph of site {} is at version {}; version {} is not one of the last {} that this server keeps",
                  site.value(), current->graph().version(), version, kKeptVersions);
}

void SiteGraphs::MarkChanged(const SiteId& site) {
  MutexLock lock(mutex_);
  const auto found = entries_.find(site);
  if (found != entries_.end()) found->second->changes_needed = ++found->second->changes;
}

void SiteGraphs::Forget(const SiteId& site) {
  MutexLock lock(mutex_);
  entries_.erase(site);
}

void SiteGraphs::MarkAllChanged() {
  MutexLock lock(mutex_);
  for (auto& [site, entry] : entries_) entry->changes_needed = ++entry->changes;
}

void SiteGraphs::Listen() {
  while (!stop_.is_set()) {
    auto listener = store_.Listen(storage::CallContext::WithTimeout(kConnectTimeout));
    if (!listener.ok()) {
      stop_.WaitFor(kReconnectInterval);
      continue;
    }
    // Changes before the listener was opened were not reported.
    MarkAllChanged();
    {
      MutexLock lock(mutex_);
      listening_ = true;
    }
    ProcessChanges(**listener);
    MutexLock lock(mutex_);
    listening_ = false;
  }
}

void SiteGraphs::ProcessChanges(storage::GraphListener& listener) {
  auto next_check = steady_clock::now() + kCheckInterval;
  while (!stop_.is_set()) {
    const auto changes = listener.Await(storage::CallContext::WithTimeout(kListenTimeout));
    if (!changes.ok()) {
      spdlog::warn("lost the connection that reports changed graphs: {}", changes.status().ToString());
      return;
    }
    for (const storage::GraphListener::Change& change : *changes) OnGraphChanged(change);
    if (steady_clock::now() < next_check) continue;
    if (const absl::Status checked = CheckVersions(); !checked.ok()) {
      spdlog::warn("cannot check the versions of graphs: {}", checked.ToString());
    }
    next_check = steady_clock::now() + kCheckInterval;
  }
}

absl::Status SiteGraphs::CheckVersions() {
  std::vector<SiteId> sites;
  {
    MutexLock lock(mutex_);
    for (const auto& [site, entry] : entries_) {
      if (entry->current != nullptr) sites.push_back(site);
    }
  }
  if (sites.empty()) return absl::OkStatus();
  ENFILADE_ASSIGN_OR_RETURN(const auto versions,
                            store_.ListVersionsOf(storage::CallContext::WithTimeout(kConnectTimeout), sites));
  for (const storage::GraphListener::Change& version : versions) OnGraphChanged(version);
  return absl::OkStatus();
}

void SiteGraphs::OnGraphChanged(const storage::GraphListener::Change& change) {
  {
    MutexLock lock(mutex_);
    const auto found = entries_.find(change.site);
    if (found != entries_.end()) {
      const std::shared_ptr<const SiteGraph>& current = found->second->current;
      if (current != nullptr && current->graph().version() >= change.version) return;
      ++found->second->changes;
    }
  }
  // Sites without readers are read as well: their graphs must be optimised.
  ReadFor(change.site, [this, site = change.site](const Result& read) {
    if (read.ok() || absl::IsNotFound(read.status())) return;
    spdlog::warn("cannot read the graph of {}: {}", site.value(), read.status().ToString());
    MarkChanged(site);  // the next Get tries again
  });
}

}  // namespace enfilade::server
