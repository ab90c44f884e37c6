// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/site_graphs.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "spdlog/spdlog.h"

namespace enfilade::server {
namespace {

constexpr std::size_t kKeptVersions = 8;
constexpr auto kListenTimeout = std::chrono::milliseconds(500);
constexpr auto kReadTimeout = std::chrono::seconds(30);
constexpr auto kConnectTimeout = std::chrono::seconds(5);
constexpr auto kReconnectInterval = std::chrono::seconds(1);

}  // namespace

// What has to be applied to a snapshot at an earlier version.
struct SiteGraphs::Update {
  storage::GraphChanges changes;
  std::int64_t solution_version = 0;  // of the last optimisation, at most changes.version; 0: none since
};

SiteGraphs::SiteGraphs(const storage::GraphStore& store, ChangedSites& changed) : store_(store), changed_(changed) {
  listener_ = std::thread([this] { Listen(); });
}

SiteGraphs::~SiteGraphs() {
  Stop();
  listener_.join();
}

void SiteGraphs::Stop() { stop_.Set(); }

std::shared_ptr<SiteGraphs::Entry> SiteGraphs::FindOrMake(const SiteId& site) {
  MutexLock lock(mutex_);
  std::shared_ptr<Entry>& entry = entries_[site];
  if (entry == nullptr) entry = std::make_shared<Entry>();
  return entry;
}

std::shared_ptr<const SiteGraph> SiteGraphs::FindCurrent(const SiteId& site) const {
  MutexLock lock(mutex_);
  const auto found = entries_.find(site);
  if (found == entries_.end() || !listening_) return nullptr;
  const Entry& entry = *found->second;
  return entry.changes_read >= entry.changes_needed ? entry.current : nullptr;
}

absl::StatusOr<std::shared_ptr<const SiteGraph>> SiteGraphs::Get(const storage::CallContext& context,
                                                                 const SiteId& site) {
  if (std::shared_ptr<const SiteGraph> current = FindCurrent(site)) return current;
  return BringUpToDate(context, site);
}

absl::StatusOr<std::shared_ptr<const SiteGraph>> SiteGraphs::BringUpToDate(const storage::CallContext& context,
                                                                           const SiteId& site) {
  const std::shared_ptr<Entry> entry = FindOrMake(site);
  MutexLock reading(entry->reading);
  std::shared_ptr<const SiteGraph> old;
  std::uint64_t changes = 0;
  {
    MutexLock lock(mutex_);
    old = entry->current;
    changes = entry->changes;
    // Another thread has read the changes while this one waited.
    if (listening_ && entry->changes_read == changes) return old;
  }
  absl::StatusOr<std::shared_ptr<const SiteGraph>> read = Read(context, site, old);
  {
    MutexLock lock(mutex_);
    if (!read.ok()) {
      if (absl::IsNotFound(read.status())) entries_.erase(site);
      return read.status();
    }
    entry->changes_read = changes;
    if (*read == old) return read;
    entry->current = *read;
    entry->recent.push_front(*read);
    if (entry->recent.size() > kKeptVersions) entry->recent.pop_back();
  }
  changed_.Add(site);
  return read;
}

absl::StatusOr<std::shared_ptr<const SiteGraph>> SiteGraphs::GetVersion(const storage::CallContext& context,
                                                                        const SiteId& site, std::int64_t version) {
  ENFILADE_ASSIGN_OR_RETURN(std::shared_ptr<const SiteGraph> current, Get(context, site));
  if (version == 0 || version == current->graph().version()) return current;
  const std::shared_ptr<Entry> entry = FindOrMake(site);
  MutexLock lock(mutex_);
  for (const std::shared_ptr<const SiteGraph>& kept : entry->recent) {
    if (kept->graph().version() == version) return kept;
  }
  return NotFound("the graph of site {} is at version {}; version {} is not one of the last {} that this server keeps",
                  site.value(), current->graph().version(), version, entry->recent.size());
}

// The store reads the changes and the last optimisation separately. If an optimisation is committed in between, its
// poses belong to a later version than the changes, which are then read again.
absl::StatusOr<SiteGraphs::Update> SiteGraphs::ReadUpdate(const storage::CallContext& context, const SiteId& site,
                                                          std::int64_t since, std::int64_t known_solution) const {
  Update update;
  do {
    ENFILADE_ASSIGN_OR_RETURN(update.changes, store_.ReadChanges(context, site, since));
    const bool unchanged = since != 0 && update.changes.version == since;
    if (unchanged) return update;
    // Optimisations up to `since` have been considered before.
    const std::int64_t considered = update.changes.complete ? 0 : std::max(known_solution, since);
    ENFILADE_ASSIGN_OR_RETURN(update.solution_version, store_.FindLastOptimization(context, site, considered));
  } while (update.solution_version > update.changes.version);
  return update;
}

absl::StatusOr<std::shared_ptr<const SiteGraph>> SiteGraphs::Read(const storage::CallContext& context,
                                                                  const SiteId& site,
                                                                  const std::shared_ptr<const SiteGraph>& old) const {
  const std::int64_t since = old == nullptr ? 0 : old->graph().version();
  ENFILADE_ASSIGN_OR_RETURN(const Update update,
                            ReadUpdate(context, site, since, old == nullptr ? 0 : old->solution_version));
  const storage::GraphChanges& changes = update.changes;
  if (old != nullptr && changes.version == since) return old;
  graph::SnapshotChanges snapshot_changes = ToSnapshotChanges(changes);
  const bool complete = changes.complete || old == nullptr;
  std::int64_t solution_version = complete ? 0 : old->solution_version;
  if (update.solution_version > 0) {
    const auto poses = store_.GetMapPoses(context, site, update.solution_version);
    if (!poses.ok() && !absl::IsNotFound(poses.status())) return poses.status();
    if (poses.ok()) snapshot_changes.solution = ToSolvedGraph(*poses, update.solution_version, changes.root);
    if (snapshot_changes.solution != nullptr) solution_version = update.solution_version;
  }
  ENFILADE_ASSIGN_OR_RETURN(graph::GraphSnapshot snapshot,
                            graph::Apply(complete ? graph::GraphSnapshot() : old->graph(), snapshot_changes));
  auto graph = std::make_shared<SiteGraph>(std::move(snapshot));
  const graph::SolvedGraph* solution = graph->graph().solution();
  graph->solution_version = solution != nullptr && solution->root == graph->graph().root() ? solution_version : 0;
  ENFILADE_ASSIGN_OR_RETURN(graph->control_points, store_.GetControlPoints(context, site));
  if (!graph->control_points.empty()) {
    auto fit = FitControlPoints(graph->poses, graph->control_points);
    if (fit.ok()) {
      graph->georeference = *std::move(fit);
    } else {
      spdlog::warn("site {}: no georeference: {}", site.value(), fit.status().ToString());
    }
  }
  return std::shared_ptr<const SiteGraph>(std::move(graph));
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
  while (!stop_.is_set()) {
    const auto changes = listener.Await(storage::CallContext::WithTimeout(kListenTimeout));
    if (!changes.ok()) {
      spdlog::warn("lost the connection that reports changed graphs: {}", changes.status().ToString());
      return;
    }
    for (const storage::GraphListener::Change& change : *changes) OnGraphChanged(change);
  }
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
  const auto read = BringUpToDate(storage::CallContext::WithTimeout(kReadTimeout), change.site);
  if (read.ok() || absl::IsNotFound(read.status())) return;
  spdlog::warn("cannot read the graph of {}: {}", change.site.value(), read.status().ToString());
  MarkChanged(change.site);  // the next Get tries again
}

}  // namespace enfilade::server
