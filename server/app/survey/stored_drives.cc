// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/stored_drives.h"

#include <algorithm>
#include <cstdint>
#include <limits>

#include "fmt/format.h"

namespace enfilade::server {
namespace {

// One for each beginning of the drive that is some of its sessions.
std::vector<std::string> KeysOf(const StoredDrive& drive, Environment environment) {
  std::vector<std::string> keys;
  std::int64_t scans = 0;
  std::int64_t odometry = 0;
  std::int64_t bytes = 0;
  TimeNs first = std::numeric_limits<TimeNs>::max();
  TimeNs last = std::numeric_limits<TimeNs>::min();
  for (const storage::Session* session : drive) {
    scans += session->record_counts.laser_scans;
    odometry += session->record_counts.odometry;
    bytes += session->payload_bytes;
    first = std::min(first, session->first_time.value_or(first));
    last = std::max(last, session->last_time.value_or(last));
    keys.push_back(fmt::format("/{} {} {}-{} {} {} {}", drive.front()->robot.value(), static_cast<int>(environment),
                               first, last, scans, odometry, bytes));
  }
  return keys;
}

bool AreDoorsJudged(const storage::Session& session) {
  return session.doors_judged || session.record_counts.door_reports == 0;
}

}  // namespace

bool IsSettled(const storage::Session& session) {
  return session.map && session.state == storage::SessionState::kMapped && AreDoorsJudged(session);
}

bool IsUnderWay(const storage::Session& session) {
  return session.state == storage::SessionState::kRecording || session.state == storage::SessionState::kFinished ||
         !AreDoorsJudged(session);
}

std::vector<StoredDrive> DrivesOn(int level, const std::vector<storage::Session>& sessions,
                                  const std::map<MapId, storage::Map>& maps) {
  std::map<SessionId, const storage::Session*> here;
  for (const storage::Session& session : sessions) {
    if (!IsSettled(session) || session.records_deleted) continue;
    const auto map = maps.find(*session.map);
    if (map != maps.end() && map->second.level == level) here.emplace(session.id, &session);
  }
  std::map<SessionId, const storage::Session*> next;
  std::vector<const storage::Session*> first;
  for (const storage::Session& session : sessions) {
    if (!here.contains(session.id)) continue;
    const bool follows = session.entry.previous && here.contains(*session.entry.previous) &&
                         next.emplace(*session.entry.previous, &session).second;
    if (!follows) first.push_back(&session);
  }
  std::vector<StoredDrive> drives;
  for (const storage::Session* session : first) {
    StoredDrive& drive = drives.emplace_back();
    while (session != nullptr) {
      drive.push_back(session);
      const auto found = next.find(session->id);
      session = found == next.end() ? nullptr : found->second;
    }
  }
  return drives;
}

std::string KeyOf(const StoredDrive& drive, Environment environment) { return KeysOf(drive, environment).back(); }

std::string BeginningOf(const StoredDrive& drive, Environment environment) {
  TimeNs first = std::numeric_limits<TimeNs>::max();
  for (const storage::Session* session : drive) first = std::min(first, session->first_time.value_or(first));
  return fmt::format("/{} {} {}", drive.front()->robot.value(), static_cast<int>(environment), first);
}

std::size_t CountSessionsOf(const std::string& key, const StoredDrive& drive, Environment environment) {
  const std::vector<std::string> keys = KeysOf(drive, environment);
  const auto found = std::find(keys.rbegin(), keys.rend(), key);
  return static_cast<std::size_t>(keys.rend() - found);
}

}  // namespace enfilade::server
