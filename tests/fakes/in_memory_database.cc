// SPDX-License-Identifier: Apache-2.0
#include "tests/fakes/in_memory_database.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "tests/fakes/session_rows.h"

namespace enfilade::testing {

void InMemoryDatabase::AddSite(const SiteId& site) {
  const std::lock_guard lock(mutex_);
  tables_[site];
}

void InMemoryDatabase::AddRobot(const SiteId& site, const RobotId& robot) {
  const std::lock_guard lock(mutex_);
  tables_.at(site).robots.insert(robot);
}

void InMemoryDatabase::EnterMap(const SiteId& site, const SessionId& session, const MapId& map,
                                const PoseWithCovariance& T_map_robot) {
  const std::lock_guard lock(mutex_);
  SiteRows& rows = tables_.at(site);
  SessionRow& row = rows.sessions.at(session);
  row.session.map = map;
  row.session.entry.T_map_robot = T_map_robot;
  FollowRedirect(rows, row.session);
  QueueWork(row, std::chrono::steady_clock::now() + clock_offset_);
}

void InMemoryDatabase::ExpireRecords(const SiteId& site, const SessionId& session) {
  const std::lock_guard lock(mutex_);
  SessionRow& row = tables_.at(site).sessions.at(session);
  row.records.clear();
  row.session.records_deleted = true;
}

void InMemoryDatabase::CorruptRecord(const SiteId& site, const SessionId& session, std::int64_t sequence) {
  const std::lock_guard lock(mutex_);
  tables_.at(site).sessions.at(session).records.at(sequence).payload = std::string(1, '\0');
}

void InMemoryDatabase::FailCalls(absl::Status status) {
  const std::lock_guard lock(mutex_);
  failure_ = std::move(status);
  changed_.notify_all();
}

void InMemoryDatabase::AdvanceClock(std::chrono::milliseconds time) {
  const std::lock_guard lock(mutex_);
  clock_offset_ += time;
}

std::int64_t InMemoryDatabase::CountBlobs() const {
  const std::lock_guard lock(mutex_);
  std::size_t count = 0;
  for (const auto& [id, site] : tables_) count += site.blobs.size();
  return static_cast<std::int64_t>(count);
}

std::int64_t InMemoryDatabase::CountRecords() const {
  const std::lock_guard lock(mutex_);
  std::size_t count = 0;
  for (const auto& [id, site] : tables_) {
    for (const auto& [session_id, session] : site.sessions) count += session.records.size();
  }
  return static_cast<std::int64_t>(count);
}

std::int64_t InMemoryDatabase::CountRevisions() const {
  const std::lock_guard lock(mutex_);
  std::size_t count = 0;
  for (const auto& [id, site] : tables_) {
    for (const auto& [map_id, map] : site.maps) count += map.revisions.size();
  }
  return static_cast<std::int64_t>(count);
}

absl::StatusOr<InMemoryDatabase::Access> InMemoryDatabase::Open(const storage::CallContext& context) {
  std::unique_lock lock(mutex_);
  ENFILADE_RETURN_IF_ERROR(failure_);
  if (context.cancellation.stop_requested()) return absl::CancelledError("the caller has cancelled the call");
  if (context.deadline <= std::chrono::steady_clock::now()) {
    return absl::DeadlineExceededError("the deadline has passed");
  }
  Access access(*this, std::move(lock));
  access.set_actor(context.actor);
  return access;
}

SiteRows* InMemoryDatabase::Access::FindSite(const SiteId& site) {
  const auto found = database_->tables_.find(site);
  return found == database_->tables_.end() ? nullptr : &found->second;
}

absl::StatusOr<SiteRows*> InMemoryDatabase::Access::GetSite(const SiteId& site) {
  SiteRows* found = FindSite(site);
  if (found == nullptr) return NotFound("{} does not exist", NameOf(site));
  return found;
}

absl::StatusOr<SessionRow*> InMemoryDatabase::Access::GetSession(const SiteId& site, const SessionId& session) {
  SiteRows* rows = FindSite(site);
  if (rows != nullptr) {
    const auto found = rows->sessions.find(session);
    if (found != rows->sessions.end() && !found->second.deleted) return &found->second;
  }
  return NotFound("{} does not exist", NameOf(site, session));
}

absl::StatusOr<MapRow*> InMemoryDatabase::Access::GetMap(const SiteId& site, const MapId& map) {
  SiteRows* rows = FindSite(site);
  if (rows != nullptr) {
    const auto found = rows->maps.find(map);
    if (found != rows->maps.end()) return &found->second;
  }
  return NotFound("{} does not exist", NameOf(site, map));
}

absl::StatusOr<MapRow*> InMemoryDatabase::Access::GetMapInUse(const SiteId& site, const MapId& map) {
  ENFILADE_ASSIGN_OR_RETURN(MapRow* const row, GetMap(site, map));
  if (row->redirect) return NotFound("{} does not exist", NameOf(site, map));
  return row;
}

std::chrono::steady_clock::time_point InMemoryDatabase::Access::Now() const {
  return std::chrono::steady_clock::now() + database_->clock_offset_;
}

TimeNs InMemoryDatabase::Access::Timestamp() {
  const auto now = std::chrono::duration_cast<std::chrono::microseconds>(
      std::chrono::system_clock::now().time_since_epoch() + database_->clock_offset_);
  database_->last_timestamp_ = std::max<TimeNs>(database_->last_timestamp_ + 1000, now.count() * 1000);
  return database_->last_timestamp_;
}

std::int64_t InMemoryDatabase::Access::NewEtag() { return ++database_->last_etag_; }

std::int64_t InMemoryDatabase::Access::RaiseVersion(const SiteId& site, storage::GraphCause cause,
                                                    const std::string& resource) {
  GraphRows& graph = database_->tables_.at(site).graph;
  const std::int64_t version = ++graph.version;
  graph.versions[version] = {version, cause, resource, actor_, Timestamp(), std::nullopt};
  database_->changes_.push_back({site, version});
  database_->changed_.notify_all();
  return version;
}

void InMemoryDatabase::Access::RollBack(const SiteId& site, GraphRows before) {
  std::erase_if(database_->changes_, [&](const storage::GraphListener::Change& change) {
    return change.site == site && change.version > before.version;
  });
  database_->tables_.at(site).graph = std::move(before);
}

class InMemoryDatabase::Listener final : public storage::GraphListener {
 public:
  Listener(InMemoryDatabase& database, std::size_t first) : database_(database), next_(first) {}

  absl::StatusOr<std::vector<Change>> Await(const storage::CallContext& context) override {
    std::unique_lock lock(database_.mutex_);
    database_.changed_.wait_until(lock, context.deadline,
                                  [&] { return next_ < database_.changes_.size() || !database_.failure_.ok(); });
    ENFILADE_RETURN_IF_ERROR(database_.failure_);
    std::vector<Change> changes(database_.changes_.begin() + static_cast<std::ptrdiff_t>(next_),
                                database_.changes_.end());
    next_ = database_.changes_.size();
    return changes;
  }

 private:
  InMemoryDatabase& database_;
  std::size_t next_;
};

absl::StatusOr<std::unique_ptr<storage::GraphListener>> InMemoryDatabase::Listen(const storage::CallContext& context) {
  ENFILADE_RETURN_IF_ERROR(Open(context).status());
  const std::lock_guard lock(mutex_);
  return std::unique_ptr<storage::GraphListener>(std::make_unique<Listener>(*this, changes_.size()));
}

}  // namespace enfilade::testing
