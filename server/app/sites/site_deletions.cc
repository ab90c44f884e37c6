// SPDX-License-Identifier: Apache-2.0
#include "server/app/sites/site_deletions.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/base/status_macros.h"
#include "spdlog/spdlog.h"

namespace enfilade::server {
namespace {

using std::chrono::steady_clock;

constexpr auto kDeletionTimeout = std::chrono::seconds(30);

}  // namespace

SiteDeletions::SiteDeletions(Options options, const storage::SiteStore& sites, const storage::SiteDeletion& deletion,
                             Metrics& metrics)
    : options_(std::move(options)), sites_(sites), deletion_(deletion), metrics_(metrics) {
  thread_ = std::thread([this] { Run(); });
}

SiteDeletions::~SiteDeletions() {
  Stop();
  thread_.join();
}

void SiteDeletions::Stop() {
  stop_.Set();
  wake_.Wake();
}

absl::StatusOr<storage::Site> SiteDeletions::Begin(const storage::CallContext& context, const SiteId& site,
                                                   std::int64_t etag, bool force) {
  ENFILADE_ASSIGN_OR_RETURN(storage::Site deleted, sites_.Delete(context, site, etag, force));
  Add(site);
  wake_.Wake();
  return deleted;
}

bool SiteDeletions::IsBeingDeleted(std::string_view site) const {
  if (!any_) return false;
  MutexLock lock(mutex_);
  return deleted_.contains(std::string(site));
}

void SiteDeletions::Add(const SiteId& site) {
  {
    MutexLock lock(mutex_);
    if (!deleted_.insert(site.value()).second) return;
    any_ = true;
  }
  options_.forget(site);
}

void SiteDeletions::SetDeleted(const std::vector<storage::DeletedSite>& sites) {
  for (const storage::DeletedSite& site : sites) Add(site.id);
  MutexLock lock(mutex_);
  std::erase_if(deleted_, [&](const std::string& known) {
    return std::none_of(sites.begin(), sites.end(),
                        [&](const storage::DeletedSite& site) { return site.id.value() == known; });
  });
  any_ = !deleted_.empty();
  metrics_.SetSitesDeleting(static_cast<int>(deleted_.size()));
}

void SiteDeletions::Run() {
  bool busy = false;
  while (!stop_.is_set()) {
    if (!busy) wake_.WaitFor(options_.interval);
    busy = false;
    if (stop_.is_set() || !options_.is_ready()) continue;
    const auto begin = steady_clock::now();
    const auto sites = deletion_.List(storage::CallContext::WithTimeout(kDeletionTimeout));
    if (!sites.ok()) {
      spdlog::warn("cannot look for deleted sites: {}", sites.status().ToString());
      continue;
    }
    SetDeleted(*sites);
    busy = DeletePortions(*sites);
    // Leaves others as much of the database's time as it takes.
    if (busy) stop_.WaitFor(std::min<steady_clock::duration>(steady_clock::now() - begin, options_.interval));
  }
}

bool SiteDeletions::DeletePortions(const std::vector<storage::DeletedSite>& sites) {
  using Progress = storage::SiteDeletion::Progress;
  bool busy = false;
  for (const storage::DeletedSite& site : sites) {
    if (stop_.is_set()) return false;
    storage::CallContext context = storage::CallContext::WithTimeout(kDeletionTimeout);
    context.actor = site.actor;
    const auto portion = deletion_.DeletePortion(context, site.id, kPortionRows);
    if (!portion.ok()) {
      spdlog::warn("deleting a site: {}", portion.status().ToString());
      continue;
    }
    metrics_.CountRowsDeleted("deleted sites", portion->rows);
    busy = busy || portion->progress != Progress::kTaken;
    if (portion->progress == Progress::kDone) spdlog::info("site {} is deleted", site.id.value());
  }
  return busy;
}

}  // namespace enfilade::server
