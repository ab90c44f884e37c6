// SPDX-License-Identifier: Apache-2.0
#include "server/app/watch/site_looks.h"

#include <utility>

#include "core/base/status_macros.h"

namespace enfilade::server {
namespace {

// Sites that are looked at at the same time.
constexpr int kSiteLookers = 2;
constexpr std::size_t kMaxQueuedSiteLooks = 1000;
// A transaction that finished or deleted something may have taken so long to be committed.
constexpr DurationNs kSlowCommit = 10 * kNsPerSecond;

storage::ActivityQuery QueryAfter(const ActivityView* before) {
  storage::ActivityQuery query;
  if (before == nullptr) return query;
  for (const storage::SessionProgress& session : before->activity.sessions) {
    if (!session.is_over()) query.also.push_back(session.id);
  }
  query.since = before->activity.time - kSlowCommit;
  return query;
}

}  // namespace

SiteLooks::SiteLooks(PoseLooks& poses, const storage::ActivityStore& activity, const Options& options)
    : poses_(poses), activity_(activity), options_(options), readers_(kSiteLookers, kMaxQueuedSiteLooks) {}

SiteLooks::~SiteLooks() { Stop(); }

void SiteLooks::Stop() { readers_.Stop(); }

void SiteLooks::Look(const SiteId& site, std::function<void(const Result&)> then) {
  {
    MutexLock lock(mutex_);
    ForgetUnwatched(Clock::now());
    Entry& entry = entries_[site];
    entry.waiters.push_back(std::move(then));
    if (std::exchange(entry.looking, true)) return;
  }
  poses_.Look(site, [this, site](const PoseLooks::Result& poses) {
    if (!poses.ok()) return Answer(site, poses.status());
    readers_.PostNext([this, site, poses = *poses] { Answer(site, Read(site, poses)); });
  });
}

// One at a time of a site.
SiteLooks::Result SiteLooks::Read(const SiteId& site, std::shared_ptr<const SitePoses> poses) {
  std::shared_ptr<const SiteMoment> before;
  bool is_due = false;
  {
    MutexLock lock(mutex_);
    const Entry& entry = entries_[site];
    before = entry.last;
    is_due = before == nullptr || Clock::now() >= entry.activity_read + options_.activity_interval;
  }
  SiteMoment moment;
  ENFILADE_ASSIGN_OR_RETURN(moment.graph, Following(before == nullptr ? nullptr : before->graph, poses->graph));
  moment.poses = std::move(poses);
  if (before != nullptr) moment.activity = before->activity;
  if (is_due) {
    const storage::CallContext context = storage::CallContext::WithTimeout(options_.timeout);
    ENFILADE_ASSIGN_OR_RETURN(storage::SiteActivity activity,
                              activity_.Read(context, site, QueryAfter(moment.activity.get())));
    moment.activity = Following(moment.activity, std::move(activity));
    MutexLock lock(mutex_);
    entries_[site].activity_read = Clock::now();
  }
  if (before != nullptr && *before == moment) return before;
  return std::make_shared<const SiteMoment>(std::move(moment));
}

void SiteLooks::Answer(const SiteId& site, const Result& look) {
  std::vector<Waiter> waiters;
  {
    MutexLock lock(mutex_);
    Entry& entry = entries_[site];
    waiters = std::exchange(entry.waiters, {});
    entry.looking = false;
    entry.looked = Clock::now();
    if (look.ok()) {
      entry.last = *look;
    } else if (absl::IsNotFound(look.status())) {
      entries_.erase(site);
    }
  }
  for (const Waiter& waiter : waiters) waiter(look);
}

void SiteLooks::ForgetUnwatched(Clock::time_point now) {
  if (now < swept_ + options_.kept / 10) return;
  swept_ = now;
  std::erase_if(entries_,
                [&](const auto& item) { return !item.second.looking && item.second.looked + options_.kept < now; });
}

}  // namespace enfilade::server
