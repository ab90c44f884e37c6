// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/pose_looks.h"

#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::server {
namespace {

using std::chrono::steady_clock;

// Sites that are looked at at the same time.
constexpr int kLookers = 2;
constexpr std::size_t kMaxQueuedLooks = 1000;

}  // namespace

PoseLooks::PoseLooks(SiteGraphs& graphs, const storage::RobotPoseStore& reports, const Options& options)
    : graphs_(graphs), reports_(reports), options_(options), readers_(kLookers, kMaxQueuedLooks) {}

PoseLooks::~PoseLooks() { Stop(); }

void PoseLooks::Stop() { readers_.Stop(); }

absl::StatusOr<PoseLooks::Watcher> PoseLooks::Admit(const SiteId& site) {
  MutexLock lock(mutex_);
  if (watchers_ >= options_.max_in_all) {
    return ResourceExhausted("{} watchers are as many as this server takes: try again in a minute", watchers_);
  }
  const auto found = entries_.find(site);
  if (found != entries_.end() && found->second.watchers >= options_.max_per_site) {
    return ResourceExhausted("sites/{} has {} watchers, as many as this server takes: try again in a minute",
                             site.value(), found->second.watchers);
  }
  ++watchers_;
  ++entries_[site].watchers;
  return Watcher(this, [this, site](const void*) { Leave(site); });
}

int PoseLooks::watchers() {
  MutexLock lock(mutex_);
  return watchers_;
}

void PoseLooks::Leave(const SiteId& site) {
  MutexLock lock(mutex_);
  --watchers_;
  --entries_[site].watchers;
  DropUnused(site);
}

void PoseLooks::DropUnused(const SiteId& site) {
  const auto found = entries_.find(site);
  if (found->second.watchers == 0 && !found->second.looking) entries_.erase(found);
}

void PoseLooks::Look(const SiteId& site, std::function<void(const Result&)> then) {
  std::shared_ptr<const SitePoses> last;
  bool is_fresh = false;
  {
    MutexLock lock(mutex_);
    Entry& entry = entries_[site];
    last = entry.last;
    is_fresh = last != nullptr && steady_clock::now() < entry.taken + options_.fresh;
    if (!is_fresh) {
      entry.waiters.push_back(std::move(then));
      if (std::exchange(entry.looking, true)) return;
    }
  }
  if (is_fresh) return then(last);
  graphs_.Prepare(site, [this, site, last](const absl::Status& ready) {
    if (!ready.ok()) return Answer(site, ready);
    readers_.PostNext([this, site, last] { Answer(site, Read(site, last)); });
  });
}

PoseLooks::Result PoseLooks::Read(const SiteId& site, const std::shared_ptr<const SitePoses>& before) const {
  const storage::CallContext context = storage::CallContext::WithTimeout(options_.timeout);
  ENFILADE_ASSIGN_OR_RETURN(const auto graph, graphs_.Get(context, site));
  ENFILADE_ASSIGN_OR_RETURN(auto reports, reports_.List(context, site));
  return Following(before, graph, std::move(reports));
}

void PoseLooks::Answer(const SiteId& site, const Result& look) {
  std::vector<Waiter> waiters;
  {
    MutexLock lock(mutex_);
    Entry& entry = entries_[site];
    waiters = std::exchange(entry.waiters, {});
    entry.looking = false;
    if (look.ok()) {
      entry.last = *look;
      entry.taken = steady_clock::now();
    }
    DropUnused(site);
  }
  for (const Waiter& waiter : waiters) waiter(look);
}

}  // namespace enfilade::server
